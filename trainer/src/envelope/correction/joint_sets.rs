//! Selection of the joints and curves that are inputs of kernel maps (METHOD §1.9, §1.10). The helpers of a joint share
//! one joint set or use several.

use super::features::{near, neighbours, on_side};
use super::target::{CorrectionTarget, EachOutputs, groups};
use crate::envelope::lbs::projection::RIDGE;
use crate::envelope::model::{Feature, Input};
use crate::progress::Progress;
use crate::regression::design::Design;
use crate::regression::function::SMOOTHEST_FIRST;
use crate::regression::inputs::{Inputs, WIDTHS};
use crate::regression::outputs::Outputs;
use crate::regression::ridge;
use crate::settings::TIED;
use faer::Side;
use faer::linalg::solvers::Solve;
use rayon::prelude::*;
use sinew_runtime::envelope::GroupKernel;
use std::collections::BTreeMap;
use std::ops::Range;

/// Name of the step.
const STEP: &str = "inputs of kernel maps";
/// Candidate hops, the fewest inputs first.
const HOPS: [usize; 3] = [1, 2, 3];
/// Largest number of centres while inputs are chosen. 128 centres do not show the inputs that a larger map needs.
const CENTRES: usize = 192;

/// Joint sets of each dominant joint: one, or several for different helpers.
pub type JointSets = BTreeMap<usize, Vec<JointSet>>;

/// Input joints of a kernel map, and its kernel.
#[derive(Clone)]
pub struct JointSet {
    /// Largest number of hops to an input joint.
    pub hops: usize,
    /// Features of the joints, then curves.
    pub inputs: Vec<Input>,
    /// Kernel, and its squared width in median squared distances.
    pub kernel: (GroupKernel, f64),
}

/// Chooses the joint sets of each dominant joint.
pub fn choose(target: &CorrectionTarget<'_>, progress: &dyn Progress) -> JointSets {
    let groups = groups(target.dominant.len(), |helper| target.dominant[helper]);
    progress.step(STEP, groups.len());
    let of_joint = |helpers: Range<usize>| {
        let joint = target.dominant[helpers.start];
        let sets = of_joint(target, helpers);
        progress.advance(1);
        (joint, sets)
    };
    groups.into_par_iter().map(of_joint).collect()
}

/// Returns the index of the joint set with the best score for each helper, P.
pub fn assign(target: &CorrectionTarget<'_>, joint_sets: &JointSets) -> Vec<usize> {
    let groups = groups(target.dominant.len(), |helper| target.dominant[helper]);
    let of_joint = |helpers: Range<usize>| -> Vec<usize> {
        let len = helpers.len();
        let sets = joint_sets.get(&target.dominant[helpers.start]).map_or(&[][..], Vec::as_slice);
        if sets.len() < 2 {
            return vec![0; len];
        }
        let scores = Scores::new(target, &EachOutputs::new(target, helpers), sets);
        let all: Vec<usize> = (0..sets.len()).collect();
        (0..len).map(|helper| scores.best(&all, helper).0).collect()
    };
    groups.into_par_iter().map(of_joint).collect::<Vec<_>>().concat()
}

/// Chooses joint sets for the helpers of a joint.
///
/// The first set is for all helpers. Further sets have fewer or more joints, or the joints on one side: an armpit uses
/// its own arm. A set is added as long as the sum of each helper's best score falls by enough.
pub(super) fn of_joint(target: &CorrectionTarget<'_>, helpers: Range<usize>) -> Vec<JointSet> {
    let joint = target.dominant[helpers.start];
    let each = EachOutputs::new(target, helpers);
    let Some(first) = JointSet::near(target, &each.outputs, joint) else { return Vec::new() };
    let (own_joints, own_curves): (Vec<Input>, Vec<Input>) =
        first.inputs.iter().partition(|input| !matches!(input.feature, Feature::Curve(_)));
    let joints = candidate_joints(target.features.parents, joint).map(|(hops, joints)| {
        let inputs = target.features.inputs(target.poses, &joints);
        (hops, [&inputs[..], &own_curves].concat())
    });
    let curves = Curves::new(target, &each.outputs, &own_joints);
    let curves = curves.prefixes().map(|curves| (first.hops, [&own_joints[..], curves].concat()));
    let mut sets = vec![first.clone()];
    for (hops, inputs) in joints.chain(curves) {
        if sets.iter().all(|known| known.inputs != inputs) {
            sets.push(JointSet { hops, inputs, ..first });
        }
    }
    let scores = Scores::new(target, &each, &sets);
    let mut taken = vec![0];
    loop {
        let with = |set: usize| scores.sum(&[&taken[..], &[set]].concat());
        let best = (0..sets.len()).min_by(|&a, &b| with(a).total_cmp(&with(b)));
        match best.filter(|&best| {
            (1.0 + target.features.settings.input_tie) * with(best) < scores.sum(&taken)
        }) {
            Some(best) => taken.push(best),
            None => break,
        }
    }
    // Other helpers may later use a set that none of these helpers uses.
    let refined = |&set: &usize| {
        let outputs = each.of(|helper| scores.best(&taken, helper).0 == set);
        outputs
            .and_then(|outputs| sets[set].with_best_kernel(target, &outputs))
            .unwrap_or(sets[set].clone())
    };
    taken.iter().map(refined).collect()
}

/// Lists candidate joints for the joint sets of a joint, with their hops: the joints nearby, on all sides or on one
/// side.
fn candidate_joints(
    parents: &[Option<usize>],
    joint: usize,
) -> impl Iterator<Item = (usize, Vec<usize>)> {
    HOPS.into_iter().flat_map(move |hops| {
        let all = near(parents, joint, hops);
        let side = |side| on_side(parents, joint, side, &all);
        let sides: Vec<_> = neighbours(parents, joint).map(side).collect();
        std::iter::once(all).chain(sides).map(move |joints| (hops, joints))
    })
}

/// The curves that vary over the poses, the most relevant first.
struct Curves(Vec<Input>);

impl Curves {
    /// Ranks the curves by what they add to a linear fit of the outputs beside the inputs of joints.
    fn new(target: &CorrectionTarget<'_>, outputs: &Outputs, joints: &[Input]) -> Self {
        let curves = target.features.curves(target.poses);
        if curves.len() < 2 {
            return Self(curves);
        }
        let inputs = [joints, &curves].concat();
        let values = target.features.evaluate(target.poses, &inputs);
        let mut gram = &values * values.transpose();
        let mean = gram.diagonal().column_vector().sum() / gram.nrows() as f64;
        (0..gram.nrows()).for_each(|i| gram[(i, i)] += RIDGE * mean + f64::MIN_POSITIVE);
        let Ok(factor) = gram.llt(Side::Lower) else { return Self(curves) };
        let solution = factor.solve(&values * &outputs.all);
        let size = |at: usize| solution.row(joints.len() + at).squared_norm_l2();
        let mut order: Vec<usize> = (0..curves.len()).collect();
        // Curves have equal spreads, so the coefficients compare.
        order.sort_by(|&a, &b| size(b).total_cmp(&size(a)));
        Self(order.into_iter().map(|at| curves[at]).collect())
    }

    /// Lists candidate sets: none, the most relevant, twice as many, and so on to all.
    fn prefixes(&self) -> impl Iterator<Item = &[Input]> {
        let doubled = std::iter::successors(Some(1), |len| Some(2 * len));
        let some = doubled.take_while(|&len| len < self.0.len());
        let all = Some(self.0.len()).filter(|len| *len > 0);
        std::iter::once(0).chain(some).chain(all).map(|len| &self.0[..len])
    }
}

/// Score of each joint set for each helper.
struct Scores(Vec<Vec<f64>>);

impl Scores {
    fn new(target: &CorrectionTarget<'_>, each: &EachOutputs, sets: &[JointSet]) -> Self {
        let of = |set: &JointSet| {
            let scores = set.scores(target, &each.outputs);
            scores.map_or(vec![f64::INFINITY; each.helper_len], |all| each.by_helper(&all))
        };
        Self(sets.iter().map(of).collect())
    }

    /// Finds the joint set among `sets` with the best score for a helper. Returns its index and score.
    fn best(&self, sets: &[usize], helper: usize) -> (usize, f64) {
        let scores = sets.iter().map(|&set| (set, self.0[set][helper]));
        scores.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY))
    }

    /// Sums the best scores of all helpers.
    fn sum(&self, sets: &[usize]) -> f64 {
        (0..self.0[0].len()).map(|helper| self.best(sets, helper).1).sum()
    }
}

impl JointSet {
    /// Chooses joints and the width of the smoothest kernel; `None` if nothing near the joint moves.
    ///
    /// Among tied sets the narrowest kernel wins, then the fewest joints. A narrow kernel fades first outside the
    /// trained range.
    fn near(target: &CorrectionTarget<'_>, outputs: &Outputs, joint: usize) -> Option<Self> {
        let mut tried = Vec::<(Self, f64)>::new();
        for hops in HOPS {
            let joints = near(target.features.parents, joint, hops);
            let inputs = target.features.inputs(target.poses, &joints);
            let with = |curves: &[Input]| {
                let inputs = [&inputs[..], curves].concat();
                narrowest(target, outputs, (hops, &inputs), (SMOOTHEST_FIRST[0], &WIDTHS))
            };
            let curves = Curves::new(target, outputs, &inputs);
            let of: Vec<(Self, f64)> = curves.prefixes().filter_map(with).collect();
            let least = of.iter().map(|tried| tried.1).fold(f64::INFINITY, f64::min);
            let found = of.into_iter().find(|tried| tried.1 <= TIED * least);
            let is_new = |found: &(Self, f64)| {
                tried.last().is_none_or(|last| last.0.inputs != found.0.inputs)
            };
            tried.extend(found.filter(is_new));
        }
        let tried = tied(target, tried).into_iter().map(|tried| tried.0);
        tried.min_by(|a, b| a.kernel.1.total_cmp(&b.kernel.1))
    }

    /// Chooses the kernel for the joints of the set, and a width near the present width.
    fn with_best_kernel(&self, target: &CorrectionTarget<'_>, outputs: &Outputs) -> Option<Self> {
        // The roughest kernel is never the best.
        let [kernels @ .., _] = SMOOTHEST_FIRST;
        let (_, own) = self.kernel;
        let widths: Vec<f64> =
            WIDTHS.into_iter().filter(|width| (own / 4.0..=own * 4.0).contains(width)).collect();
        let of = |kernel| narrowest(target, outputs, (self.hops, &self.inputs), (kernel, &widths));
        let tried = kernels.into_iter().filter_map(of);
        tried.min_by(|a, b| a.1.total_cmp(&b.1)).map(|tried| tried.0)
    }

    /// Scores each output; `None` if no input moves.
    fn scores(&self, target: &CorrectionTarget<'_>, outputs: &Outputs) -> Option<Vec<f64>> {
        let values = Inputs::new(target.features.evaluate(target.poses, &self.inputs))?;
        scores(&values, outputs, self.kernel)
    }
}

/// Chooses the narrowest width of a kernel that ties with the best width. Returns the joint set and its score.
fn narrowest(
    target: &CorrectionTarget<'_>,
    outputs: &Outputs,
    (hops, inputs): (usize, &[Input]),
    (kernel, widths): (GroupKernel, &[f64]),
) -> Option<(JointSet, f64)> {
    let values = Inputs::new(target.features.evaluate(target.poses, inputs))?;
    let of_width = |&width: &f64| {
        let kernel = (kernel, width);
        let score = scores(&values, outputs, kernel)?.iter().sum();
        Some((JointSet { hops, inputs: inputs.to_vec(), kernel }, score))
    };
    tied(target, widths.iter().filter_map(of_width).collect()).into_iter().next()
}

/// Scores each output for a kernel and width.
fn scores(
    inputs: &Inputs,
    outputs: &Outputs,
    (kernel, width): (GroupKernel, f64),
) -> Option<Vec<f64>> {
    let count = inputs.sample_len().min(CENTRES);
    Some(ridge::best(&Design::each(inputs, kernel, width, &[count]).next()?, outputs)?.scores)
}

/// Keeps the joint sets whose scores tie with the best score.
fn tied(target: &CorrectionTarget<'_>, mut tried: Vec<(JointSet, f64)>) -> Vec<(JointSet, f64)> {
    let least = tried.iter().map(|tried| tried.1).fold(f64::INFINITY, f64::min);
    tried.retain(|tried| tried.1 <= (1.0 + target.features.settings.input_tie) * least);
    tried
}
