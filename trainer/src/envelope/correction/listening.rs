//! What a group's map listens to, and by which kernel, chosen by folds of the training poses.

use super::blocks::Blocks;
use super::features::{Features, near, neighbours, on_side};
use super::group_outputs::{EachOutputs, GroupOutputs, groups};
use super::target::CorrectionTarget;
use crate::constants::{EARNS, LISTS, SIMPLER, TELLS_NOTHING};
use crate::envelope::model::Input;
use crate::envelope::skin::poses::Poses;
use crate::kernel::design::Design;
use crate::kernel::function::SMOOTHEST_FIRST;
use crate::kernel::inputs::{Inputs, WIDTHS};
use crate::kernel::outputs::Outputs;
use crate::kernel::ridge;
use crate::progress::Progress;
use rayon::prelude::*;
use sinew_runtime::envelope::GroupKernel;
use std::collections::BTreeMap;
use std::ops::Range;

/// Name of the step.
const STEP: &str = "what maps listen to";
/// Candidate hops, the fewest inputs first.
const HOPS: [usize; 3] = [1, 2, 3];
/// What a joint's weight is multiplied by, at most so many times: joints that hardly move would be all rounding.
const FACTORS: [f64; 2] = [0.5, 2.0];
const TIMES: usize = 2;
/// Most centres that what maps listen to is chosen with: 128 are too few to tell what a map of more needs.
const CENTRES: usize = 192;

/// What the maps of some joints listen to: of each joint one list, or several for different helpers.
pub type Known = BTreeMap<usize, Vec<Listening>>;

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

/// Chooses for each dominant joint what the maps of its proxies listen to, in as many lists at most.
pub fn choose(target: &CorrectionTarget<'_>, most: usize, progress: &dyn Progress) -> Known {
    let blocks = Blocks::new(target.poses.times(), target.without.is_empty());
    let groups = groups(target.dominant.len(), |proxy| target.dominant[proxy]);
    progress.step(STEP, groups.len());
    let of_joint = |proxies: Range<usize>| {
        let joint = target.dominant[proxies.start];
        let lists = if most > 1 && proxies.len() > 1 {
            several(target, proxies, &blocks, most)
        } else {
            let GroupOutputs { outputs, .. } = GroupOutputs::new(target, proxies, &blocks);
            Listening::choose(&outputs, target.poses, target.features, joint).into_iter().collect()
        };
        progress.advance(1);
        (joint, lists)
    };
    groups.into_par_iter().map(of_joint).collect()
}

/// Chooses lists for several proxies of a joint: one for all, and further ones, of fewer or more joints or of those on one
/// side of theirs, as long as what each proxy's best list scores falls by enough. An armpit hears its own arm.
fn several(
    target: &CorrectionTarget<'_>,
    proxies: Range<usize>,
    blocks: &Blocks,
    most: usize,
) -> Vec<Listening> {
    let CorrectionTarget { poses, features, .. } = *target;
    let joint = target.dominant[proxies.start];
    let each = EachOutputs::new(target, proxies, blocks, TELLS_NOTHING.get());
    let Some(first) = choose_joints(&each.outputs, poses, features, joint) else {
        return Vec::new();
    };
    let width = first.width;
    let mut taken: Vec<(NearJoints, Vec<f64>)> = first.scored(&each, width).into_iter().collect();
    let mut others: Vec<_> = sets(features.parents, joint)
        .filter_map(|(hops, joints)| {
            NearJoints::new(poses, features, hops, &joints)?.scored(&each, width)
        })
        .collect();
    let Some((_, least)) = taken.first() else { return Vec::new() };
    let mut least = least.clone();
    while taken.len() < most {
        let with = |scores: &[f64]| lesser(&least, scores).iter().sum::<f64>();
        let best =
            (0..others.len()).min_by(|&a, &b| with(&others[a].1).total_cmp(&with(&others[b].1)));
        let Some(best) = best else { break };
        if (1.0 + LISTS.get()) * with(&others[best].1) >= least.iter().sum() {
            break;
        }
        least = lesser(&least, &others[best].1);
        taken.push(others.swap_remove(best));
    }
    let owner = |proxy: usize| {
        let lists = 0..taken.len();
        lists.min_by(|&a, &b| taken[a].1[proxy].total_cmp(&taken[b].1[proxy])).unwrap_or(0)
    };
    let owners: Vec<usize> = (0..least.len()).map(owner).collect();
    let of_list = |(list, (near, _)): (usize, (NearJoints, Vec<f64>))| {
        let outputs = each.of(|proxy| owners[proxy] == list);
        if outputs.all.ncols() == 0 {
            return None;
        }
        let (width, score) = best_width(&near.values, &outputs, SMOOTHEST_FIRST[0], near.width)?;
        let near = NearJoints { width, score, ..near };
        Some(near.listening(&outputs, poses, features))
    };
    taken.into_iter().enumerate().filter_map(of_list).collect()
}

/// Sets of joints that a list of a joint may name, with their hops: those near it, on all sides or on one.
fn sets(parents: &[Option<usize>], joint: usize) -> impl Iterator<Item = (usize, Vec<usize>)> {
    let mut sets = Vec::<(usize, Vec<usize>)>::new();
    for hops in HOPS {
        let all = near(parents, joint, hops);
        let sides = neighbours(parents, joint).map(|side| on_side(parents, joint, side, &all));
        for set in std::iter::once(all.clone()).chain(sides) {
            if !set.is_empty() && sets.iter().all(|known| known.1 != set) {
                sets.push((hops, set));
            }
        }
    }
    sets.into_iter()
}

/// The lesser of two numbers of each proxy.
fn lesser(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a.min(*b)).collect()
}

/// Says of each proxy which of its joint's lists predicts it best.
pub fn assign(target: &CorrectionTarget<'_>, known: &Known) -> Vec<usize> {
    let blocks = Blocks::new(target.poses.times(), target.without.is_empty());
    let groups = groups(target.dominant.len(), |proxy| target.dominant[proxy]);
    let of_joint = |proxies: Range<usize>| -> Vec<usize> {
        let len = proxies.len();
        let lists = known.get(&target.dominant[proxies.start]).map_or(&[][..], Vec::as_slice);
        if lists.len() < 2 {
            return vec![0; len];
        }
        let each = EachOutputs::new(target, proxies, &blocks, TELLS_NOTHING.get());
        let score = |list: &Listening| {
            let values = Inputs::new(target.features.evaluate(target.poses, &list.inputs))?;
            scores(&values, &each, list.kernel)
        };
        let scores: Vec<Option<Vec<f64>>> = lists.iter().map(score).collect();
        let of = |proxy: usize, list: usize| {
            scores[list].as_ref().map_or(f64::INFINITY, |scores| scores[proxy])
        };
        let best = |proxy: usize| {
            (0..lists.len()).min_by(|&a, &b| of(proxy, a).total_cmp(&of(proxy, b))).unwrap_or(0)
        };
        (0..len).map(best).collect()
    };
    groups.into_par_iter().map(of_joint).collect::<Vec<_>>().concat()
}

impl Listening {
    /// Chooses joints, kernel, width and weights for the outputs of a joint's group; none where nothing moves.
    pub(super) fn choose(
        outputs: &Outputs,
        poses: &Poses,
        features: Features<'_>,
        joint: usize,
    ) -> Option<Self> {
        let telling = outputs.leading(TELLS_NOTHING.get());
        let near = choose_joints(&telling, poses, features, joint)?;
        Some(near.listening(&telling, poses, features))
    }
}

/// The joints within some hops, and what the smoothest kernel makes of them.
struct NearJoints {
    hops: usize,
    inputs: Vec<Input>,
    values: Inputs,
    /// Which of [`WIDTHS`] is best, and its score.
    width: usize,
    score: f64,
}

/// Chooses the joints to listen to, by the smoothest kernel: of those that score alike the narrowest, which fades first in
/// poses unlike those of training, and then the fewest.
fn choose_joints(
    outputs: &Outputs,
    poses: &Poses,
    features: Features<'_>,
    joint: usize,
) -> Option<NearJoints> {
    let mut tried = Vec::<NearJoints>::new();
    for hops in HOPS {
        let joints = near(features.parents, joint, hops);
        let Some(near) = NearJoints::new(poses, features, hops, &joints) else { continue };
        if tried.last().is_some_and(|last| last.inputs == near.inputs) {
            continue;
        }
        let from = tried.last().map_or(near.width, |last| last.width);
        if let Some((width, score)) = best_width(&near.values, outputs, SMOOTHEST_FIRST[0], from) {
            tried.push(NearJoints { width, score, ..near });
        }
    }
    let least = tried.iter().map(|t| t.score).min_by(f64::total_cmp)?;
    let alike = tried.into_iter().filter(|t| t.score <= (1.0 + EARNS.get()) * least);
    alike.min_by_key(|t| t.width)
}

/// Chooses kernel and width, the smoothest kernel that will do, and gives their score.
fn choose_kernel(near: &NearJoints, outputs: &Outputs) -> ((GroupKernel, f64), f64) {
    let [smoothest, rougher @ ..] = SMOOTHEST_FIRST;
    let rougher = rougher.into_iter().filter_map(|kernel| {
        let (width, score) = best_width(&near.values, outputs, kernel, near.width)?;
        Some((kernel, width, score))
    });
    let tried: Vec<_> =
        std::iter::once((smoothest, near.width, near.score)).chain(rougher).collect();
    let least = tried.iter().map(|t| t.2).fold(f64::INFINITY, f64::min);
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
    let score = |width: usize| coarse(inputs, outputs, (kernel, *WIDTHS.get(width)?));
    let mut best = (from, score(from).unwrap_or(f64::INFINITY));
    for step in [1, -1] {
        let next = |width: usize| {
            let next = width.checked_add_signed(step)?;
            score(next).map(|score| (next, score))
        };
        while let Some(found) = next(best.0).filter(|found| found.1 < best.1) {
            best = found;
        }
        if best.0 != from {
            break;
        }
    }
    // Of widths that score alike the narrowest, which fades first.
    let alike = (1.0 + EARNS.get()) * best.1;
    while let Some(width) = best.0.checked_sub(1) {
        match score(width).filter(|&score| score <= alike) {
            Some(score) => best = (width, score),
            None => break,
        }
    }
    Some(best).filter(|best| best.1.is_finite())
}

/// Scores a kernel and width with centres enough to tell.
fn coarse(inputs: &Inputs, outputs: &Outputs, kernel: (GroupKernel, f64)) -> Option<f64> {
    ridge::coarse(&telling(inputs, kernel)?, outputs)
}

/// The same of each proxy.
fn scores(inputs: &Inputs, each: &EachOutputs, kernel: (GroupKernel, f64)) -> Option<Vec<f64>> {
    let columns = ridge::coarse_each(&telling(inputs, kernel)?, &each.outputs)?;
    Some(each.by_proxy(&columns))
}

fn telling(inputs: &Inputs, (kernel, width): (GroupKernel, f64)) -> Option<Design<'_>> {
    Design::each(inputs, kernel, width, &[inputs.sample_len().min(CENTRES)]).next()
}

impl NearJoints {
    /// Takes joints; none where nothing of them moves.
    fn new(poses: &Poses, features: Features<'_>, hops: usize, joints: &[usize]) -> Option<Self> {
        let inputs = features.inputs(poses, joints);
        let values = Inputs::new(features.evaluate(poses, &inputs))?;
        Some(Self { hops, inputs, values, width: WIDTHS.len() / 2, score: f64::INFINITY })
    }

    /// Scores each proxy by the smoothest kernel, at the best of a width and its neighbours.
    fn scored(mut self, each: &EachOutputs, around: usize) -> Option<(Self, Vec<f64>)> {
        let kernel = |width: usize| (SMOOTHEST_FIRST[0], WIDTHS[width]);
        let mut least: Option<Vec<f64>> = None;
        for width in around.saturating_sub(1)..(around + 2).min(WIDTHS.len()) {
            let Some(scores) = scores(&self.values, each, kernel(width)) else { continue };
            let score = scores.iter().sum();
            if score < self.score {
                (self.width, self.score) = (width, score);
            }
            least = Some(least.map_or(scores.clone(), |least| lesser(&least, &scores)));
        }
        Some((self, least?))
    }

    /// Chooses the kernel and weighs the joints.
    fn listening(mut self, outputs: &Outputs, poses: &Poses, features: Features<'_>) -> Listening {
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
                        Some(found) if (1.0 + EARNS.get()) * found < least => least = found,
                        _ => break,
                    }
                    (self.inputs, self.values) = (inputs, values);
                }
            }
        }
    }
}
