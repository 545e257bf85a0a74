//! Columns of matrices: filled in parallel, selected, multiplied, solved for and clustered.
//!
//! faer runs on one thread here, so that results do not depend on the number of threads.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use std::hint::black_box;

/// Most rounds of k-means.
const ROUNDS: usize = 30;

/// Writes every column of a matrix, in parallel.
pub(crate) fn fill(matrix: &mut Mat<f64>, write: impl Fn(usize, &mut [f64]) + Sync) {
    let columns: Vec<_> = matrix.col_iter_mut().enumerate().collect();
    columns.into_par_iter().for_each_init(narrow_registers, |(), (index, column)| {
        if let Some(column) = column.try_as_col_major_mut() {
            write(index, column.as_slice_mut());
        }
    });
}

/// Returns the matrix of the selected columns.
pub(crate) fn some(matrix: &Mat<f64>, columns: &[usize]) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), columns.len(), |row, k| matrix[(row, columns[k])])
}

/// Lists the columns that belong to affine maps; each map has four columns.
pub(crate) fn of_maps(maps: &[usize]) -> Vec<usize> {
    maps.iter().flat_map(|l| 4 * l..4 * l + 4).collect()
}

/// Returns the smallest and the largest number; infinity and minus infinity for an empty list.
pub(crate) fn ends<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> [f64; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    numbers.into_iter().fold(none, |[least, most], &x| [least.min(x), most.max(x)])
}

/// Returns the index of the largest number, the first if there are several; 0 for an empty list.
pub(crate) fn largest(numbers: &[f64]) -> usize {
    let last_first = numbers.iter().enumerate().rev();
    last_first.max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(index, _)| index)
}

/// Returns a·b, summed in order.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Returns a·b, summed in four lanes that a processor can add at once.
pub(crate) fn dot_by_lanes(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 4];
    let (x, x_rest) = a.as_chunks::<4>();
    let (y, y_rest) = b.as_chunks::<4>();
    for (p, q) in x.iter().zip(y) {
        for k in 0..4 {
            lanes[k] += p[k] * q[k];
        }
    }
    let tail: f64 = x_rest.iter().zip(y_rest).map(|(p, q)| p * q).sum();
    lanes.iter().sum::<f64>() + tail
}

/// Solves `(gram + ridge I) x = right`; returns zeros if rounding makes the matrix indefinite.
pub(crate) fn solve_ridge(gram: &mut Mat<f64>, right: Mat<f64>, ridge: f64) -> Mat<f64> {
    for i in 0..gram.nrows() {
        gram[(i, i)] += ridge + f64::MIN_POSITIVE;
    }
    match gram.llt(Side::Lower) {
        Ok(factor) => factor.solve(right),
        Err(_) => Mat::zeros(right.nrows(), right.ncols()),
    }
}

/// Computes a small norm in faer, so that the thread leaves the wide vector registers.
///
/// faer's products leave the wide registers in use. On some CPUs all other arithmetic of the thread then takes ten
/// times as long (*measured*).
pub(crate) fn narrow_registers() {
    black_box(black_box(Mat::<f64>::identity(8, 8)).norm_l2());
}

/// Splits the columns of `points` (d x n) into at most `count` groups by k-means; returns the group of each column.
///
/// The first centres are drawn with a fixed seed, so equal points give equal groups.
pub(crate) fn cluster(points: &Mat<f64>, count: usize) -> Vec<usize> {
    let mut centres = seeds(points, count);
    let mut group = vec![0; points.ncols()];
    for _ in 0..ROUNDS {
        let next: Vec<usize> = (0..points.ncols())
            .into_par_iter()
            .map(|i| nearest(points.col_as_slice(i), &centres))
            .collect();
        if next == group {
            break;
        }
        group = next;
        let mut sums = vec![(0usize, vec![0.0; points.nrows()]); centres.len()];
        for (i, &g) in group.iter().enumerate() {
            sums[g].0 += 1;
            sums[g].1.iter_mut().zip(points.col_as_slice(i)).for_each(|(s, x)| *s += x);
        }
        for (centre, (members, sum)) in centres.iter_mut().zip(sums) {
            if members > 0 {
                *centre = sum.into_iter().map(|s| s / members as f64).collect();
            }
        }
    }
    group
}

/// Draws the first centres: each with a probability proportional to its squared distance from the centres before.
fn seeds(points: &Mat<f64>, count: usize) -> Vec<Vec<f64>> {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let n = points.ncols();
    let mut centres = vec![points.col_as_slice(random.random_range(0..n)).to_vec()];
    let mut distances = vec![f64::INFINITY; n];
    while centres.len() < count.min(n) {
        let last = &centres[centres.len() - 1];
        for (i, distance) in distances.iter_mut().enumerate() {
            *distance = distance.min(squared(points.col_as_slice(i), last));
        }
        let total: f64 = distances.iter().sum();
        if total <= 0.0 {
            break;
        }
        let mut left = random.random_range(0.0..total);
        let chosen = distances.iter().position(|d| {
            left -= d;
            left < 0.0
        });
        centres.push(points.col_as_slice(chosen.unwrap_or(n - 1)).to_vec());
    }
    centres
}

fn nearest(point: &[f64], centres: &[Vec<f64>]) -> usize {
    let distances = centres.iter().map(|centre| squared(point, centre)).enumerate();
    distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(index, _)| index)
}

fn squared(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distant_points_are_in_different_groups() {
        let points = Mat::from_fn(2, 30, |r, i| (i / 10 * 10) as f64 + 0.1 * ((r + i) % 7) as f64);
        let group = cluster(&points, 3);
        for i in 0..30 {
            for j in 0..30 {
                assert_eq!(group[i] == group[j], i / 10 == j / 10, "{i} {j}");
            }
        }
    }

    #[test]
    fn there_are_at_most_as_many_groups_as_distinct_points() {
        let points = Mat::from_fn(2, 8, |_, i| (i % 2) as f64);
        let group = cluster(&points, 5);
        assert!(group.iter().all(|&g| g < 2) && group[0] != group[1] && group[0] == group[2]);
    }
}
