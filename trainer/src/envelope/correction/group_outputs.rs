//! What the map of a group has to learn: what is left over of its proxies' transforms, measured where the skin is.

use super::features::near;
use super::metric::Metric;
use super::target::CorrectionTarget;
use crate::envelope::lbs::poses::Poses;
use crate::envelope::lbs::stacked::map_of;
use crate::regression::outputs::{Block, Outputs};
use faer::Mat;
use nalgebra::Matrix3;
use std::ops::Range;

/// RMS error of the whole skin, in diagonals, that counts as none.
const NOTHING: f64 = 2e-4;

/// What the map of a group has to learn.
pub struct GroupOutputs {
    /// The dominant joint.
    pub joint: usize,
    /// The group's proxies.
    pub proxies: Range<usize>,
    /// How their transforms' entries are measured.
    pub metric: Metric,
    /// The leading directions of what is left over, 12p x r.
    pub directions: Mat<f64>,
    /// What is left over along them.
    pub outputs: Outputs,
}

impl GroupOutputs {
    /// Measures what is left over of some proxies of one dominant joint.
    pub fn new(target: &CorrectionTarget<'_>, proxies: Range<usize>) -> Self {
        let joint = target.dominant[proxies.start];
        let beyond = beyond(target, joint);
        Self::in_blocks(target, proxies, (target.folds.overlapping(), &beyond))
    }

    /// The same, with the blocks that samples are left out in, and those beyond.
    fn in_blocks(
        target: &CorrectionTarget<'_>,
        proxies: Range<usize>,
        (blocks, beyond): (&[Block], &[Block]),
    ) -> Self {
        let CorrectionTarget { poses, folds, features, .. } = *target;
        let joint = target.dominant[proxies.start];
        let metric = Metric::new(target.gram, &proxies);
        let all = metric.weigh(&local(target.left_over, poses, joint, &proxies));
        let directions = leading(&all, features.settings.negligible);
        let signal: f64 = target.lbs_errors[proxies.clone()].iter().sum();
        let outputs = Outputs {
            all: &all * &directions,
            extrapolated_len: beyond.len(),
            blocks: [blocks, beyond].concat(),
            parts: folds.parts().to_vec(),
            signal,
            negligible: NOTHING.powi(2) * target.vertices as f64,
            root_limit: target.certainty,
        };
        Self { joint, proxies, metric, directions, outputs }
    }
}

/// Outputs of several proxies, each measured by itself, side by side.
pub struct EachOutputs {
    /// All of them.
    pub outputs: Outputs,
    /// Whose each column is, counted from the first proxy.
    owners: Vec<usize>,
    /// How many proxies there are, those that have nothing left over among them.
    pub proxy_len: usize,
}

impl EachOutputs {
    /// Measures what is left over of some proxies of one dominant joint.
    ///
    /// Lists of joints differ by much, so that blocks that overlap tell no more of them than runs do.
    ///
    /// # Panics
    /// If there is no proxy.
    pub fn new(target: &CorrectionTarget<'_>, proxies: Range<usize>) -> Self {
        let beyond = beyond(target, target.dominant[proxies.start]);
        let blocks = (target.folds.runs(), &beyond[..]);
        let each: Vec<Outputs> =
            proxies.map(|l| GroupOutputs::in_blocks(target, l..l + 1, blocks).outputs).collect();
        let columns = |(k, own): (usize, &Outputs)| std::iter::repeat_n(k, own.all.ncols());
        let owners = each.iter().enumerate().flat_map(columns).collect();
        Self { outputs: Outputs::beside(&each), owners, proxy_len: each.len() }
    }

    /// Sums what there is of each column by proxy.
    pub fn by_proxy(&self, columns: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.proxy_len];
        self.owners.iter().zip(columns).for_each(|(&k, value)| sums[k] += value);
        sums
    }

    /// Returns the outputs of some proxies; `None` if nothing of them is left over.
    pub fn of(&self, is_own: impl Fn(usize) -> bool) -> Option<Outputs> {
        let own: Vec<usize> =
            (0..self.owners.len()).filter(|&column| is_own(self.owners[column])).collect();
        (!own.is_empty()).then(|| self.outputs.columns(&own))
    }
}

/// The blocks that maps of a joint have to extrapolate to.
fn beyond(target: &CorrectionTarget<'_>, joint: usize) -> Vec<Block> {
    let CorrectionTarget { poses, folds, features, .. } = target;
    folds.beyond(poses, &near(features.parents, joint, 1), features.settings.beyond)
}

/// Splits proxies into groups: those that follow one another and share a place.
pub fn groups<P: PartialEq>(len: usize, place: impl Fn(usize) -> P) -> Vec<Range<usize>> {
    let mut ranges = Vec::<Range<usize>>::new();
    for proxy in 0..len {
        match ranges.last_mut() {
            Some(range) if place(range.start) == place(proxy) => range.end = proxy + 1,
            _ => ranges.push(proxy..proxy + 1),
        }
    }
    ranges
}

/// What is left over of a group's maps, in its joint's frame: n x 12 a proxy, column
/// `r 4h + 4 k + c` is entry r, c of proxy k's.
fn local(left_over: &Mat<f64>, poses: &Poses, joint: usize, proxies: &Range<usize>) -> Mat<f64> {
    let width = 4 * proxies.len();
    let mut out = Mat::zeros(poses.len(), 3 * width);
    for pose in 0..poses.len() {
        let turn: Matrix3<f64> = poses.map(pose, joint).fixed_columns::<3>(0).into();
        for (k, proxy) in proxies.clone().enumerate() {
            let map = turn.transpose() * map_of(left_over, pose, proxy);
            for r in 0..3 {
                for c in 0..4 {
                    out[(pose, r * width + 4 * k + c)] = map[(r, c)];
                }
            }
        }
    }
    out
}

/// The leading right singular directions, without the last ones that carry a negligible share of the squared size.
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
