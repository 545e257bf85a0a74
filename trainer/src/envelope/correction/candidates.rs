//! The candidates for a group's kernel map, chosen by folds of the training poses.

use super::group_outputs::GroupOutputs;
use super::listening::Listening;
use super::lists::{self, Known};
use super::metric::Metric;
use super::target::CorrectionTarget;
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

/// Candidate numbers of centres beside the origin, and the most.
const CENTRES: [usize; 6] = [8, 16, 32, 64, 128, 256];
/// How a group's map was chosen.
#[derive(Clone, Debug, Serialize)]
pub struct GroupReport {
    /// The group's joint.
    pub joint: usize,
    /// Its proxies.
    pub proxies: usize,
    /// Hops of the joints that it listens to.
    pub hops: usize,
    /// Inputs.
    pub inputs: usize,
    /// What its map is fitted with; none where there is no map.
    pub choice: Option<Hyperparameters>,
    /// Latent outputs.
    pub rank: usize,
    /// Bytes that its map takes.
    pub bytes: usize,
    /// Score without a map: squared distances of a fold, in a mean over the folds.
    pub before: f64,
    /// Score of the map, cross-validated.
    pub after: f64,
}

/// Sizes of a group's map to choose from.
pub struct GroupCandidates {
    /// The dominant joint.
    pub joint: usize,
    proxies: Range<usize>,
    /// What its map listens to; none where nothing moves.
    pub listening: Option<Listening>,
    metric: Metric,
    directions: Mat<f64>,
    outputs: Outputs,
    before: f64,
    /// By ascending bytes and descending score; the first is no map.
    pub sizes: Vec<MapSize>,
    /// The one to take where there is room.
    pub preferred: usize,
}

/// A size of a map.
#[derive(Clone)]
pub struct MapSize {
    scored: Option<Scored>,
    rank: usize,
    /// Bytes in the file.
    pub bytes: usize,
    /// Its score, the lower the better.
    pub score: f64,
}

impl GroupCandidates {
    /// Tries all there is to choose for some proxies of one dominant joint.
    ///
    /// - `known`: what joints' maps listen to.
    pub fn new(target: &CorrectionTarget<'_>, proxies: Range<usize>, known: &Known) -> Self {
        let (_, listens) = target.place(proxies.start);
        let group = GroupOutputs::new(target, proxies);
        let GroupOutputs { joint, proxies, metric, directions, outputs } = group;
        let sizes = outputs.sizes();
        let nothing = MapSize { scored: None, rank: 0, bytes: 0, score: sizes.iter().sum() };
        let before = nothing.score;
        let mut found = vec![nothing];
        // A joint whose skin LBS errs nowhere on has no helpers, but may have proxies.
        let choose = || lists::of_joint(target, proxies.clone()).into_iter().next();
        let known = known.get(&joint).and_then(|lists| lists.get(listens));
        let listening = known.cloned().or_else(choose);
        if let Some(listening) = &listening {
            let inputs = target.features.evaluate(target.poses, &listening.inputs);
            let inputs = Inputs::new(inputs);
            let found_of =
                |inputs| choose_size(&inputs, listening.kernel, &outputs, &sizes, proxies.len());
            found.extend(inputs.map(found_of).unwrap_or_default());
        }
        let sizes = undominated(found);
        let least = sizes.last().map_or(0.0, |size| size.score);
        let preferred = sizes.iter().position(|s| s.score <= TIED * least).unwrap_or(0);
        Self { joint, proxies, listening, metric, directions, outputs, before, sizes, preferred }
    }

    /// Returns a group without a map.
    pub fn nothing(&self) -> Group {
        Group::nothing(self.joint, self.proxies.clone())
    }

    /// Fits a size; also gives what each pose's latent outputs are predicted to be without its
    /// fold, n x r.
    pub fn fit(
        &self,
        target: &CorrectionTarget<'_>,
        size: &MapSize,
    ) -> (Group, GroupReport, Mat<f64>) {
        let CorrectionTarget { poses, features, .. } = *target;
        let mut report = GroupReport {
            joint: self.joint,
            proxies: self.proxies.len(),
            hops: 0,
            inputs: 0,
            choice: None,
            rank: 0,
            bytes: 0,
            before: self.before,
            after: self.before,
        };
        let mut group = self.nothing();
        let fitted = self.listening.as_ref().zip(size.scored.as_ref()).and_then(|(to, scored)| {
            let inputs = Inputs::new(features.evaluate(poses, &to.inputs))?;
            let design = Design::new(&inputs, scored.hyperparameters)?;
            Some((to, ridge::fit(&design, &self.outputs, &scored.ridges[..size.rank])?))
        });
        let Some((to, KernelFit { map, scale, predicted })) = fitted else {
            return (group, report, Mat::zeros(poses.len(), 0));
        };
        let scaled = |input: &Input| Input { weight: scale * input.weight, ..*input };
        group.inputs = to.inputs.iter().map(scaled).collect();
        group.map = map;
        group.outputs = self.metric.unweigh(&self.directions.subcols(0, size.rank).to_owned());
        report.hops = to.hops;
        report.inputs = to.inputs.len();
        report.choice = size.scored.as_ref().map(|scored| scored.hyperparameters);
        report.rank = size.rank;
        report.bytes = size.bytes;
        report.after = size.score;
        (group, report, predicted)
    }
}

/// Returns every number of centres and rank of a kernel and width.
fn choose_size(
    inputs: &Inputs,
    (kernel, width): (GroupKernel, f64),
    outputs: &Outputs,
    nothing: &[f64],
    proxies: usize,
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
                    proxies,
                ),
                score: scored.scores[..rank].iter().sum::<f64>() + left,
                scored: Some(scored.clone()),
            });
        }
    }
    sizes
}

/// Sorts by bytes and leaves out what is no better than something smaller.
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

/// Bytes that a map of d inputs, n centres, r latent outputs and m values of its certainty for p proxies adds to the
/// file.
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
