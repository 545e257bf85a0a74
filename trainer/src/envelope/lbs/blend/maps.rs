//! The fit of maps to given weights.

use super::items::{Items, Maps, Weights};
use crate::numeric::columns;
use faer::prelude::*;
use faer::{Mat, MatMut, Side};
use rayon::prelude::*;

/// Partial sums that a fit is split into, so that threads do not change the order.
const CHUNKS: usize = 4;

/// Fits the maps to given weights; a map moves from `previous` only as far as the items ask.
///
/// - `pull`: weight of the proximal term, as a share of the mean diagonal. It decides what no item
///   determines (a map without items, the direction out of a flat patch) and keeps the system positive
///   definite.
pub fn fit_maps(items: &Items<'_>, weights: &Weights, previous: &Maps, pull: f64) -> Maps {
    let m = items.width;
    let (size, rank) = (previous.columns.ncols(), items.y.nrows());
    let chunk = items.len().div_ceil(CHUNKS).max(1);
    let parts: Vec<(Mat<f64>, Mat<f64>)> = (0..items.len().div_ceil(chunk))
        .into_par_iter()
        .map_init(columns::narrow_registers, |(), c| {
            let mut normal = Mat::zeros(size, size);
            let mut right = Mat::zeros(rank, size);
            for item in c * chunk..((c + 1) * chunk).min(items.len()) {
                for row in item * items.rows..(item + 1) * items.rows {
                    accumulate(items, row, weights.of(item), item, normal.as_mut(), right.as_mut());
                }
            }
            (normal, right)
        })
        .collect();
    let mut normal = Mat::<f64>::zeros(size, size);
    let mut right = Mat::<f64>::zeros(rank, size);
    for (n, r) in &parts {
        normal += n;
        right += r;
    }
    let mean = (0..size).map(|i| normal[(i, i)]).sum::<f64>() / size.max(1) as f64;
    let proximal = pull * mean + f64::MIN_POSITIVE;
    for i in 0..size {
        normal[(i, i)] += proximal;
    }
    right += faer::Scale(proximal) * &previous.columns;
    let columns = match normal.llt(Side::Lower) {
        Ok(factor) => factor.solve(right.transpose()).transpose().to_owned(),
        // Only rounding could make it indefinite; the maps then stay as they are.
        Err(_) => previous.columns.clone(),
    };
    Maps { width: m, columns }
}

fn accumulate(
    items: &Items<'_>,
    row: usize,
    weights: impl Iterator<Item = (usize, f64)> + Clone,
    item: usize,
    mut normal: MatMut<'_, f64>,
    mut right: MatMut<'_, f64>,
) {
    let m = items.width;
    let h = items.row(row);
    let y = items.target(row);
    let counts = items.importance.of(item);
    for (a, wa) in weights.clone() {
        for (j, hj) in h.iter().enumerate() {
            let phi = counts * wa * hj;
            for (b, wb) in weights.clone() {
                for (i, hi) in h.iter().enumerate() {
                    normal[(b * m + i, a * m + j)] += phi * wb * hi;
                }
            }
            let mut column = right.as_mut().col_mut(a * m + j);
            for (k, value) in y.iter().enumerate() {
                column[k] += phi * value;
            }
        }
    }
}
