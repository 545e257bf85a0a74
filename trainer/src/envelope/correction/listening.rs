//! What a group's map listens to, and by which kernel, chosen by folds of the training poses.

use super::features::{Features, near};
use super::group_outputs::EachOutputs;
use crate::constants::{EARNS, SIMPLER, WEIGHS};
use crate::envelope::model::Input;
use crate::envelope::skin::poses::Poses;
use crate::kernel::design::Design;
use crate::kernel::function::SMOOTHEST_FIRST;
use crate::kernel::inputs::{Inputs, WIDTHS};
use crate::kernel::outputs::Outputs;
use crate::kernel::ridge;
use sinew_runtime::envelope::GroupKernel;

/// Candidate hops, the fewest inputs first.
pub(super) const HOPS: [usize; 3] = [1, 2, 3];
/// What a joint's weight is multiplied by, at most so many times: joints that hardly move would be all rounding.
const FACTORS: [f64; 2] = [0.5, 2.0];
const TIMES: usize = 2;
/// Most centres that what maps listen to is chosen with: 128 are too few to tell what a map of more needs.
const CENTRES: usize = 192;

/// The joints that a map listens to, how it weighs them, and its kernel.
#[derive(Clone)]
pub struct Listening {
    /// Hops of the joints.
    pub hops: usize,
    /// Their features.
    pub inputs: Vec<Input>,
    /// The kernel, and its squared width in median squared distances.
    pub kernel: (GroupKernel, f64),
}

/// The joints within some hops, and what the smoothest kernel makes of them.
pub(super) struct NearJoints {
    hops: usize,
    inputs: Vec<Input>,
    values: Inputs,
    /// Which of [`WIDTHS`] is best, and its score.
    width: usize,
    score: f64,
}

/// Chooses kernel and width, the smoothest kernel that will do, and gives their score: where a rougher one is worse no
/// still rougher one is tried.
fn choose_kernel(near: &NearJoints, outputs: &Outputs) -> ((GroupKernel, f64), f64) {
    let [smoothest, rougher @ ..] = SMOOTHEST_FIRST;
    let mut tried = vec![(smoothest, near.width, near.score)];
    let mut least = near.score;
    for kernel in rougher {
        let found = best_width(&near.values, outputs, kernel, near.width);
        let Some((width, score)) = found.filter(|found| found.1 <= least) else { break };
        tried.push((kernel, width, score));
        least = score;
    }
    let best = tried.iter().find(|t| t.2 <= (1.0 + SIMPLER.get()) * least).unwrap_or(&tried[0]);
    let (kernel, width, score) = *best;
    ((kernel, WIDTHS[width]), score)
}

/// The best of [`WIDTHS`] for a kernel, and its score: where it is no longer better to go on from the one to begin
/// with.
fn best_width(
    inputs: &Inputs,
    outputs: &Outputs,
    kernel: GroupKernel,
    from: usize,
) -> Option<(usize, f64)> {
    let mut known = [None; WIDTHS.len()];
    let mut score = |width: usize| {
        let coarse = || coarse(inputs, outputs, (kernel, WIDTHS[width]));
        known.get_mut(width)?.get_or_insert_with(coarse).map(|score| (width, score))
    };
    let mut best = score(from).unwrap_or((from, f64::INFINITY));
    for step in [1, -1] {
        let mut next = |width: usize| score(width.checked_add_signed(step)?);
        while let Some(found) = next(best.0).filter(|found| found.1 < best.1) {
            best = found;
        }
        if best.0 != from {
            break;
        }
    }
    // Of widths that score alike the narrowest, which fades first.
    let alike = (1.0 + EARNS.get()) * best.1;
    let mut narrower = |width: usize| score(width.checked_sub(1)?);
    while let Some(found) = narrower(best.0).filter(|found| found.1 <= alike) {
        best = found;
    }
    Some(best).filter(|best| best.1.is_finite())
}

/// Scores a kernel and width with centres enough to tell.
fn coarse(inputs: &Inputs, outputs: &Outputs, kernel: (GroupKernel, f64)) -> Option<f64> {
    ridge::coarse(&telling(inputs, kernel)?, outputs)
}

/// The same of each proxy.
pub(super) fn scores(
    inputs: &Inputs,
    each: &EachOutputs,
    kernel: (GroupKernel, f64),
) -> Option<Vec<f64>> {
    let columns = ridge::coarse_each(&telling(inputs, kernel)?, &each.outputs)?;
    Some(each.by_proxy(&columns))
}

fn telling(inputs: &Inputs, (kernel, width): (GroupKernel, f64)) -> Option<Design<'_>> {
    Design::each(inputs, kernel, width, &[inputs.sample_len().min(CENTRES)]).next()
}

impl NearJoints {
    /// Takes joints; none where nothing of them moves.
    pub(super) fn new(
        poses: &Poses,
        features: Features<'_>,
        hops: usize,
        joints: &[usize],
    ) -> Option<Self> {
        let inputs = features.inputs(poses, joints);
        let values = Inputs::new(features.evaluate(poses, &inputs))?;
        Some(Self { hops, inputs, values, width: WIDTHS.len() / 2, score: f64::INFINITY })
    }

    /// Chooses the joints to listen to, by the smoothest kernel: of those that score alike the narrowest, which fades
    /// first in poses unlike those of training, and then the fewest.
    pub(super) fn choose(
        outputs: &Outputs,
        poses: &Poses,
        features: Features<'_>,
        joint: usize,
    ) -> Option<Self> {
        let mut tried = Vec::<Self>::new();
        for hops in HOPS {
            let joints = near(features.parents, joint, hops);
            let Some(near) = Self::new(poses, features, hops, &joints) else { continue };
            if tried.last().is_some_and(|last| last.inputs == near.inputs) {
                continue;
            }
            let from = tried.last().map_or(near.width, |last| last.width);
            tried.extend(near.fitted(outputs, from));
        }
        let least = tried.iter().map(|t| t.score).min_by(f64::total_cmp)?;
        let alike = tried.into_iter().filter(|t| t.score <= (1.0 + EARNS.get()) * least);
        alike.min_by_key(|t| t.width)
    }

    /// Takes the best width, looked for from one on.
    pub(super) fn fitted(self, outputs: &Outputs, from: usize) -> Option<Self> {
        let (width, score) = best_width(&self.values, outputs, SMOOTHEST_FIRST[0], from)?;
        Some(Self { width, score, ..self })
    }

    /// Which of [`WIDTHS`] is best.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// Scores each proxy by the smoothest kernel at a width.
    pub(super) fn scores(&self, each: &EachOutputs, width: usize) -> Option<Vec<f64>> {
        scores(&self.values, each, (SMOOTHEST_FIRST[0], WIDTHS[width]))
    }

    /// Takes the smoothest kernel, and the joints as they are.
    pub(super) fn plain(self) -> Listening {
        let kernel = (SMOOTHEST_FIRST[0], WIDTHS[self.width]);
        Listening { hops: self.hops, inputs: self.inputs, kernel }
    }

    /// Chooses the kernel and weighs the joints.
    pub(super) fn listening(
        mut self,
        outputs: &Outputs,
        poses: &Poses,
        features: Features<'_>,
    ) -> Listening {
        let (kernel, score) = choose_kernel(&self, outputs);
        self.weigh_joints((kernel, score), outputs, poses, features);
        Listening { hops: self.hops, inputs: self.inputs, kernel }
    }

    /// Weighs the joints, how they move apart from how they turn, where that gains on a kernel's score.
    fn weigh_joints(
        &mut self,
        (kernel, mut least): ((GroupKernel, f64), f64),
        outputs: &Outputs,
        poses: &Poses,
        features: Features<'_>,
    ) {
        let part = |input: &Input| (input.feature / 12, input.feature % 4 == 3);
        let mut parts: Vec<_> = self.inputs.iter().map(part).collect();
        parts.sort_unstable();
        parts.dedup();
        // The weight of one alone is the kernel's width.
        for own in parts.iter().filter(|_| parts.len() > 1) {
            for factor in FACTORS {
                for _ in 0..TIMES {
                    let weigh = |input: &Input| {
                        let factor = if part(input) == *own { factor } else { 1.0 };
                        Input { weight: factor * input.weight, ..*input }
                    };
                    let inputs: Vec<Input> = self.inputs.iter().map(weigh).collect();
                    let values = Inputs::new(features.evaluate(poses, &inputs));
                    let Some(values) = values else { break };
                    match coarse(&values, outputs, kernel) {
                        Some(found) if (1.0 + WEIGHS.get()) * found < least => least = found,
                        _ => break,
                    }
                    (self.inputs, self.values) = (inputs, values);
                }
            }
        }
    }
}
