//! Targets of a correction, and regression outputs measured on the skin.

use super::features::{Features, near};
use crate::envelope::folds::Folds;
use crate::envelope::lbs::poses::Poses;
use crate::envelope::lbs::projection::RIDGE;
use crate::envelope::lbs::targets::map_of;
use crate::regression::outputs::{Block, Outputs};
use faer::linalg::triangular_solve::solve_upper_triangular_in_place;
use faer::{Mat, Par, Side};
use std::ops::Range;

/// Default of the largest number of certainty values of a map.
pub const CERTAINTY: usize = 16;
/// RMS error of the whole skin, in diagonals, that counts as 0.
const NOTHING: f64 = 2e-4;

/// Target of a correction: the part of P helper transforms that joints do not predict, on n training poses.
#[derive(Clone, Copy)]
pub struct CorrectionTarget<'a> {
    /// n training poses.
    pub poses: &'a Poses,
    /// Folds of the poses.
    pub folds: &'a Folds,
    /// Rest geometry of the joints.
    pub features: Features<'a>,
    /// Dominant joint of each helper, P. Helpers of one joint are adjacent.
    pub dominant: &'a [usize],
    /// Index of the joint set that each helper uses, P. Helpers of one joint set are adjacent. Empty if each joint has
    /// one joint set.
    pub joint_sets: &'a [usize],
    /// Helper transforms minus base transforms, 3n x 4P.
    pub residual: &'a Mat<f64>,
    /// Σ φ φᵀ over the vertices, 4P x 4P.
    pub gram: &'a Mat<f64>,
    /// Squared error of LBS that each helper has to reduce, P, summed over the poses.
    pub lbs_errors: &'a [f64],
    /// Largest number of certainty values of a map.
    pub certainty: usize,
    /// Number of vertices V.
    pub vertices: usize,
}

impl CorrectionTarget<'_> {
    /// Returns the dominant joint of a helper and the index of its joint set.
    pub fn group_key(&self, helper: usize) -> (usize, usize) {
        (self.dominant[helper], self.joint_sets.get(helper).copied().unwrap_or(0))
    }
}

/// Regression outputs of a group's kernel map: the residual of its helpers' transforms, measured on the skin.
pub struct GroupOutputs {
    /// Dominant joint of the group.
    pub joint: usize,
    /// Helpers of the group, p.
    pub helpers: Range<usize>,
    /// Metric of transform entries.
    pub metric: Metric,
    /// Leading directions of the residual, 12p x r.
    pub directions: Mat<f64>,
    /// Residual along the directions.
    pub outputs: Outputs,
}

impl GroupOutputs {
    /// Measures the residual of some helpers of one dominant joint.
    pub fn new(target: &CorrectionTarget<'_>, helpers: Range<usize>) -> Self {
        let joint = target.dominant[helpers.start];
        let range_ends = range_ends(target, joint);
        Self::in_blocks(target, helpers, (target.folds.overlapping(), &range_ends))
    }

    /// Measures the residual with given blocks for cross-validation and for extrapolation.
    fn in_blocks(
        target: &CorrectionTarget<'_>,
        helpers: Range<usize>,
        (blocks, range_ends): (&[Block], &[Block]),
    ) -> Self {
        let CorrectionTarget { poses, folds, features, .. } = *target;
        let joint = target.dominant[helpers.start];
        let metric = Metric::new(target.gram, &helpers);
        let all = metric.weigh(&local(target.residual, poses, joint, &helpers));
        let directions = leading(&all, features.settings.negligible);
        let signal: f64 = target.lbs_errors[helpers.clone()].iter().sum();
        let outputs = Outputs {
            all: &all * &directions,
            extrapolated_len: range_ends.len(),
            blocks: [blocks, range_ends].concat(),
            parts: folds.parts().to_vec(),
            signal,
            negligible: NOTHING.powi(2) * target.vertices as f64,
            root_limit: target.certainty,
        };
        Self { joint, helpers, metric, directions, outputs }
    }
}

/// Outputs of several helpers side by side, each measured alone.
pub struct EachOutputs {
    /// Outputs of all helpers.
    pub outputs: Outputs,
    /// Helper that owns each column, counted from the first helper.
    owners: Vec<usize>,
    /// Number of helpers, including helpers without a residual.
    pub helper_len: usize,
}

impl EachOutputs {
    /// Measures the residual of some helpers of one dominant joint.
    ///
    /// Scores of joint sets differ so much that runs compare them as well as overlapping blocks do.
    ///
    /// # Panics
    /// If there is no helper.
    pub fn new(target: &CorrectionTarget<'_>, helpers: Range<usize>) -> Self {
        let range_ends = range_ends(target, target.dominant[helpers.start]);
        let blocks = (target.folds.runs(), &range_ends[..]);
        let each: Vec<Outputs> =
            helpers.map(|l| GroupOutputs::in_blocks(target, l..l + 1, blocks).outputs).collect();
        let columns = |(k, own): (usize, &Outputs)| std::iter::repeat_n(k, own.all.ncols());
        let owners = each.iter().enumerate().flat_map(columns).collect();
        Self { outputs: Outputs::beside(&each), owners, helper_len: each.len() }
    }

    /// Sums the values of columns by helper.
    pub fn by_helper(&self, columns: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.helper_len];
        self.owners.iter().zip(columns).for_each(|(&k, value)| sums[k] += value);
        sums
    }

    /// Returns the outputs of some helpers; `None` if they have no residual.
    pub fn of(&self, is_own: impl Fn(usize) -> bool) -> Option<Outputs> {
        let own: Vec<usize> =
            (0..self.owners.len()).filter(|&column| is_own(self.owners[column])).collect();
        (!own.is_empty()).then(|| self.outputs.columns(&own))
    }
}

/// Metric in which transform entries of a group measure squared distances of the skin: L Lᵀ = Σ φ φᵀ.
pub struct Metric {
    factor: Mat<f64>,
}

impl Metric {
    /// Creates the metric of some of P helpers.
    ///
    /// - `gram`: Σ φ φᵀ, 4P x 4P.
    pub fn new(gram: &Mat<f64>, helpers: &Range<usize>) -> Self {
        let width = 4 * helpers.len();
        let mut own = gram.submatrix(4 * helpers.start, 4 * helpers.start, width, width).to_owned();
        let mean = own.diagonal().column_vector().sum() / width.max(1) as f64;
        (0..width).for_each(|i| own[(i, i)] += RIDGE * mean + f64::MIN_POSITIVE);
        let factor = match own.llt(Side::Lower) {
            Ok(factor) => factor.L().to_owned(),
            // Only rounding can make the matrix indefinite. All entries then get equal weights.
            Err(_) => Mat::identity(width, width),
        };
        Self { factor }
    }

    /// Weights entries so that their squares are squared distances.
    ///
    /// - `local`: n x 12p, columns `r 4p + 4k + c`.
    pub fn weigh(&self, local: &Mat<f64>) -> Mat<f64> {
        let width = self.factor.nrows();
        let mut out = Mat::zeros(local.nrows(), local.ncols());
        for r in 0..3 {
            let part = local.subcols(r * width, width) * &self.factor;
            out.subcols_mut(r * width, width).copy_from(part);
        }
        out
    }

    /// Converts weighted directions (12p x r) back to entries, rows `12k + 4r + c`.
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

/// Splits helpers into groups of adjacent helpers with equal keys.
pub fn groups<K: PartialEq>(len: usize, key: impl Fn(usize) -> K) -> Vec<Range<usize>> {
    let mut ranges = Vec::<Range<usize>>::new();
    for helper in 0..len {
        match ranges.last_mut() {
            Some(range) if key(range.start) == key(helper) => range.end = helper + 1,
            _ => ranges.push(helper..helper + 1),
        }
    }
    ranges
}

/// Returns the blocks that test the extrapolation of a joint's maps.
fn range_ends(target: &CorrectionTarget<'_>, joint: usize) -> Vec<Block> {
    let CorrectionTarget { poses, folds, features, .. } = target;
    folds.range_ends(poses, &near(features.parents, joint, 1), features.settings.range_ends)
}

/// Converts the residual of a group of p helpers to the frame of its joint: n x 12p. Column `r 4p + 4k + c` is entry
/// (r, c) of helper k.
fn local(residual: &Mat<f64>, poses: &Poses, joint: usize, helpers: &Range<usize>) -> Mat<f64> {
    let width = 4 * helpers.len();
    let mut out = Mat::zeros(poses.len(), 3 * width);
    for pose in 0..poses.len() {
        let back = poses.inverse(pose, joint);
        for (k, helper) in helpers.clone().enumerate() {
            let map = back * map_of(residual, pose, helper);
            for r in 0..3 {
                for c in 0..4 {
                    out[(pose, r * width + 4 * k + c)] = map[(r, c)];
                }
            }
        }
    }
    out
}

/// Returns the leading right singular directions. The directions left out carry at most a share `negligible` of the
/// squared size.
fn leading(values: &Mat<f64>, negligible: f64) -> Mat<f64> {
    let Ok(svd) = values.thin_svd() else { return Mat::zeros(values.ncols(), 0) };
    let s: Vec<f64> = svd.S().column_vector().iter().map(|s| s * s).collect();
    let total: f64 = s.iter().sum();
    let mut left = total;
    let rank = s.iter().take_while(|&&s| {
        let kept = left > negligible * total && s > 0.0;
        left -= s;
        kept
    });
    svd.V().subcols(0, rank.count()).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weighted_entries_measure_the_skin() {
        // A vertex at (1, 2, 3) follows the second of two helpers with weight 0.5.
        let phi = [0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.5, 0.5];
        let gram = Mat::from_fn(8, 8, |r, c| phi[r] * phi[c]);
        let metric = Metric::new(&gram, &(1..2));
        let entries = Mat::from_fn(1, 12, |_, k| k as f64 * 0.1 - 0.3);
        let squared: f64 = (0..3)
            .map(|r| (0..4).map(|c| entries[(0, 4 * r + c)] * phi[4 + c]).sum::<f64>().powi(2))
            .sum();
        let weighed = metric.weigh(&entries);
        assert!((weighed.squared_norm_l2() / squared - 1.0).abs() < 1e-4);
        let back = metric.unweigh(&weighed.transpose().to_owned());
        assert!((back.transpose() - entries).norm_max() < 1e-6);
    }
}
