//! Columns of a matrix: as slices, in parallel, and their ends; faer itself runs on one thread, so that results do
//! not depend on how many there are.

use super::registers;
use faer::Mat;
use rayon::prelude::*;

/// Writes every column of a matrix, in parallel.
pub(crate) fn fill(matrix: &mut Mat<f64>, write: impl Fn(usize, &mut [f64]) + Sync) {
    let columns: Vec<_> = matrix.col_iter_mut().enumerate().collect();
    columns.into_par_iter().for_each_init(registers::narrow, |(), (index, column)| {
        if let Some(column) = column.try_as_col_major_mut() {
            write(index, column.as_slice_mut());
        }
    });
}

/// Returns some of a matrix's columns.
pub(crate) fn some(matrix: &Mat<f64>, columns: &[usize]) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), columns.len(), |row, k| matrix[(row, columns[k])])
}

/// Lists the columns of some affine maps, of which each has four.
pub(crate) fn of_maps(maps: &[usize]) -> Vec<usize> {
    maps.iter().flat_map(|l| 4 * l..4 * l + 4).collect()
}

/// Returns the least and the greatest of numbers that are not none.
pub(crate) fn ends<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> [f64; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    numbers.into_iter().fold(none, |[least, most], &x| [least.min(x), most.max(x)])
}
