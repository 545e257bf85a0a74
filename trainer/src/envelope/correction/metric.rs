//! Distances of the skin, from entries of maps.

use crate::envelope::lbs::projection::UNSEEN;
use faer::linalg::triangular_solve::solve_upper_triangular_in_place;
use faer::{Mat, Par, Side};
use std::ops::Range;

/// The skin's squared distances that entries of a group's maps stand for: L Lᵀ = Σ φ φᵀ.
pub struct Metric {
    factor: Mat<f64>,
}

impl Metric {
    /// Takes Σ φ φᵀ (4P x 4P) of the given proxies.
    pub fn new(gram: &Mat<f64>, proxies: &Range<usize>) -> Self {
        let width = 4 * proxies.len();
        let mut own = gram.submatrix(4 * proxies.start, 4 * proxies.start, width, width).to_owned();
        let mean = own.diagonal().column_vector().sum() / width.max(1) as f64;
        (0..width).for_each(|i| own[(i, i)] += UNSEEN * mean + f64::MIN_POSITIVE);
        let factor = match own.llt(Side::Lower) {
            Ok(factor) => factor.L().to_owned(),
            // Only rounding could make it indefinite; all entries then count alike.
            Err(_) => Mat::identity(width, width),
        };
        Self { factor }
    }

    /// Weighs entries, n x 12h, columns `r 4h + 4 k + c`, so that squares are squared distances.
    pub fn weigh(&self, local: &Mat<f64>) -> Mat<f64> {
        let width = self.factor.nrows();
        let mut out = Mat::zeros(local.nrows(), local.ncols());
        for r in 0..3 {
            let part = local.subcols(r * width, width) * &self.factor;
            out.subcols_mut(r * width, width).copy_from(part);
        }
        out
    }

    /// Turns weighted directions (12h x r) to entries, rows 12 k + 4 r + c.
    pub fn unweigh(&self, directions: &Mat<f64>) -> Mat<f64> {
        let width = self.factor.nrows();
        let mut out = Mat::zeros(directions.nrows(), directions.ncols());
        for r in 0..3 {
            let mut part = directions.subrows(r * width, width).to_owned();
            solve_upper_triangular_in_place(self.factor.transpose(), part.as_mut(), Par::Seq);
            for k in 0..width / 4 {
                for c in 0..4 {
                    for o in 0..part.ncols() {
                        out[(12 * k + 4 * r + c, o)] = part[(4 * k + c, o)];
                    }
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weighed_entries_measure_the_skin_and_come_back() {
        // One vertex at (1, 2, 3) that follows the second of two proxies by a half.
        let phi = [0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.5, 0.5];
        let gram = Mat::from_fn(8, 8, |r, c| phi[r] * phi[c]);
        let metric = Metric::new(&gram, &(1..2));
        let entries = Mat::from_fn(1, 12, |_, k| k as f64 * 0.1 - 0.3);
        let moved: f64 = (0..3)
            .map(|r| (0..4).map(|c| entries[(0, 4 * r + c)] * phi[4 + c]).sum::<f64>().powi(2))
            .sum();
        let weighed = metric.weigh(&entries);
        assert!((weighed.squared_norm_l2() / moved - 1.0).abs() < 1e-4);
        let back = metric.unweigh(&weighed.transpose().to_owned());
        assert!((back.transpose() - entries).norm_max() < 1e-6);
    }
}
