//! Candidates for the kernel map of a group, scored by cross-validation on the training poses.

use super::joint_sets::{self, JointSet, JointSets};
use super::target::{CorrectionTarget, GroupOutputs};
use crate::envelope::model::{Group, Input};
use crate::regression::design::{Design, Hyperparameters};
use crate::regression::inputs::Inputs;
use crate::regression::outputs::Outputs;
use crate::regression::ridge::{self, KernelFit, Scored};
use crate::settings::TIED;
use faer::Mat;
use serde::Serialize;
use sinew_runtime::envelope::{GroupConfidence, GroupKernel, GroupRow};
use std::ops::Range;

/// Candidate numbers of centres, without the origin.
const CENTRES: [usize; 6] = [8, 16, 32, 64, 128, 256];

/// Report of the choice of a group's map.
#[derive(Clone, Debug, Default, Serialize)]
pub struct GroupReport {
    /// Dominant joint of the group.
    pub joint: usize,
    /// Number of helpers.
    pub proxies: usize,
    /// Largest number of hops to an input joint.
    pub hops: usize,
    /// Number of inputs.
    pub inputs: usize,
    /// Hyperparameters of the map; `None` if there is no map.
    pub choice: Option<Hyperparameters>,
    /// Number of latent outputs.
    pub rank: usize,
    /// Bytes of the map.
    pub bytes: usize,
    /// Score without a map: squared distances of a fold, averaged over the folds.
    pub before: f64,
    /// Cross-validated score of the map.
    pub after: f64,
}

/// Candidate sizes of a group's map.
pub struct GroupCandidates {
    group: GroupOutputs,
    /// Joint set of the map; `None` if nothing moves.
    joint_set: Option<JointSet>,
    before: f64,
    /// Sizes by ascending bytes and descending score. The first size is no map.
    pub sizes: Vec<MapSize>,
    /// Index of the preferred size if the budget allows it.
    pub preferred: usize,
}

/// Candidate size of a map.
#[derive(Clone)]
pub struct MapSize {
    scored: Option<Scored>,
    rank: usize,
    /// Bytes in the file.
    pub bytes: usize,
    /// Score; lower is better.
    pub score: f64,
}

impl GroupCandidates {
    /// Scores all candidates for some helpers of one dominant joint.
    ///
    /// - `joint_sets`: chosen joint sets of each joint.
    pub fn new(
        target: &CorrectionTarget<'_>,
        helpers: Range<usize>,
        joint_sets: &JointSets,
    ) -> Self {
        let (_, set) = target.group_key(helpers.start);
        let group = GroupOutputs::new(target, helpers);
        let GroupOutputs { joint, helpers, outputs, .. } = &group;
        let sizes = outputs.sizes();
        let nothing = MapSize { scored: None, rank: 0, bytes: 0, score: sizes.iter().sum() };
        let before = nothing.score;
        let mut found = vec![nothing];
        // Joint sets are chosen for the usual number of helpers. With another number, or on a part of the poses,
        // further joints may get helpers.
        let choose = || joint_sets::of_joint(target, helpers.clone()).into_iter().next();
        let known = joint_sets.get(joint).and_then(|sets| sets.get(set));
        let joint_set = known.cloned().or_else(choose);
        if let Some(joint_set) = &joint_set {
            let inputs = target.features.evaluate(target.poses, &joint_set.inputs);
            let inputs = Inputs::new(inputs);
            let found_of =
                |inputs| map_sizes(&inputs, joint_set.kernel, outputs, &sizes, helpers.len());
            found.extend(inputs.map(found_of).unwrap_or_default());
        }
        let sizes = undominated(found);
        let least = sizes.last().map_or(0.0, |size| size.score);
        let preferred = sizes.iter().position(|s| s.score <= TIED * least).unwrap_or(0);
        Self { group, joint_set, before, sizes, preferred }
    }

    /// Returns a group without a map.
    pub fn nothing(&self) -> Group {
        Group::nothing(self.group.joint, self.group.helpers.clone())
    }

    /// Fits a map of a size. Also returns the latent outputs of each pose, predicted without its fold, n x r.
    pub fn fit(
        &self,
        target: &CorrectionTarget<'_>,
        size: &MapSize,
    ) -> (Group, GroupReport, Mat<f64>) {
        let CorrectionTarget { poses, features, .. } = *target;
        let mut report = GroupReport {
            joint: self.group.joint,
            proxies: self.group.helpers.len(),
            before: self.before,
            after: self.before,
            ..GroupReport::default()
        };
        let mut group = self.nothing();
        let fitted = self.joint_set.as_ref().zip(size.scored.as_ref()).and_then(|(set, scored)| {
            let inputs = Inputs::new(features.evaluate(poses, &set.inputs))?;
            let design = Design::new(&inputs, scored.hyperparameters)?;
            Some((set, ridge::fit(&design, &self.group.outputs, &scored.ridges[..size.rank])?))
        });
        let Some((set, KernelFit { map, scale, predicted })) = fitted else {
            return (group, report, Mat::zeros(poses.len(), 0));
        };
        let scaled = |input: &Input| Input { weight: scale * input.weight, ..*input };
        group.inputs = set.inputs.iter().map(scaled).collect();
        group.map = map;
        let directions = self.group.directions.subcols(0, size.rank).to_owned();
        group.outputs = self.group.metric.unweigh(&directions);
        report.hops = set.hops;
        report.inputs = set.inputs.len();
        report.choice = size.scored.as_ref().map(|scored| scored.hyperparameters);
        report.rank = size.rank;
        report.bytes = size.bytes;
        report.after = size.score;
        (group, report, predicted)
    }
}

/// Lists the sizes of a map with a given kernel and width: every number of centres and every rank.
fn map_sizes(
    inputs: &Inputs,
    (kernel, width): (GroupKernel, f64),
    outputs: &Outputs,
    nothing: &[f64],
    helpers: usize,
) -> Vec<MapSize> {
    let counts = CENTRES.map(|count| count.min(inputs.sample_len()));
    let mut sizes = Vec::new();
    for design in Design::each(inputs, kernel, width, &counts) {
        let Some(scored) = ridge::best(&design, outputs) else { continue };
        for rank in 1..=nothing.len() {
            let centres = design.hyperparameters.centres + 1;
            let left: f64 = nothing[rank..].iter().sum();
            sizes.push(MapSize {
                rank,
                bytes: bytes(
                    inputs.input_len(),
                    centres,
                    rank,
                    design.root_len(outputs.root_limit),
                    helpers,
                ),
                score: scored.scores[..rank].iter().sum::<f64>() + left,
                scored: Some(scored.clone()),
            });
        }
    }
    sizes
}

/// Sorts sizes by bytes and removes each size that is no better than a smaller size.
fn undominated(mut sizes: Vec<MapSize>) -> Vec<MapSize> {
    sizes.sort_by(|a, b| a.bytes.cmp(&b.bytes).then(a.score.total_cmp(&b.score)));
    let mut least = f64::INFINITY;
    sizes.retain(|size| {
        let better = size.score < least;
        least = least.min(size.score);
        better
    });
    sizes
}

/// Returns the bytes of a map in the file, with d inputs, n centres, r latent outputs, m certainty values and p
/// helpers.
fn bytes(d: usize, n: usize, r: usize, m: usize, p: usize) -> usize {
    let narrow = |len: usize| u16::try_from(len).unwrap_or(u16::MAX);
    let row = GroupRow {
        joint: 0,
        kernel: 0,
        certainty_len: u8::try_from(m).unwrap_or(u8::MAX),
        input_len: narrow(d),
        centre_len: narrow(n),
        rank: narrow(r),
        proxy_len: narrow(p),
        offset: 0,
        confidence: GroupConfidence::default(),
    };
    4 * row.words() as usize
}
