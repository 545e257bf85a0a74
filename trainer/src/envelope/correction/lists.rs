//! Lists of joints for the maps of each joint: one, or several for helpers that hear different ones (METHOD §1.9).

use super::features::{near, neighbours, on_side};
use super::group_outputs::{EachOutputs, groups};
use super::listening::{HOPS, Listening, NearJoints, scores};
use super::target::CorrectionTarget;
use crate::constants::{EARNS, MINOR};
use crate::kernel::inputs::Inputs;
use crate::progress::Progress;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

/// Name of the step.
const STEP: &str = "what maps listen to";

/// What the maps of some joints listen to: of each joint one list, or several for different helpers.
pub type Known = BTreeMap<usize, Vec<Listening>>;

/// Chooses for each dominant joint what the maps of its proxies listen to.
pub fn choose(target: &CorrectionTarget<'_>, progress: &dyn Progress) -> Known {
    let groups = groups(target.dominant.len(), |proxy| target.dominant[proxy]);
    progress.step(STEP, groups.len());
    let each = |proxies: &Range<usize>| EachOutputs::new(target, proxies.clone());
    let each: Vec<EachOutputs> = groups.par_iter().map(each).collect();
    let is_minor = minor(&each.iter().map(|own| own.outputs.signal).collect::<Vec<_>>());
    let of_joint = |((proxies, each), is_minor): ((&Range<usize>, &EachOutputs), bool)| {
        let joint = target.dominant[proxies.start];
        let near = NearJoints::choose(&each.outputs, target.poses, target.features, joint);
        let lists = near.map_or_else(Vec::new, |near| match is_minor {
            true => vec![near.plain()],
            false => several(target, joint, each, near),
        });
        progress.advance(1);
        (joint, lists)
    };
    groups.par_iter().zip(&each).zip(is_minor).map(of_joint).collect()
}

/// Tells of signals those that are together no more than a small share of all.
fn minor(signals: &[f64]) -> Vec<bool> {
    let mut smallest_first: Vec<usize> = (0..signals.len()).collect();
    smallest_first.sort_by(|&a, &b| signals[a].total_cmp(&signals[b]));
    let mut spare = MINOR.get() * signals.iter().sum::<f64>();
    let mut is_minor = vec![false; signals.len()];
    for k in smallest_first {
        spare -= signals[k];
        is_minor[k] = spare >= 0.0;
    }
    is_minor
}

/// Chooses lists for several proxies of a joint: one for all, and further ones, of fewer or more joints or of those on one
/// side of theirs, as long as what each proxy's best list scores falls by enough. An armpit hears its own arm.
fn several(
    target: &CorrectionTarget<'_>,
    joint: usize,
    each: &EachOutputs,
    first: NearJoints,
) -> Vec<Listening> {
    let CorrectionTarget { poses, features, .. } = *target;
    let width = first.width();
    let scored = |near: NearJoints| Some((near.scores(each, width)?, near));
    let mut taken: Vec<(Vec<f64>, NearJoints)> = scored(first).into_iter().collect();
    let other = |(hops, joints): (usize, Vec<usize>)| {
        scored(NearJoints::new(poses, features, hops, &joints)?)
    };
    let sets = sets(features.parents, joint).into_iter();
    let mut others: Vec<_> = sets.filter_map(other).collect();
    let Some((least, _)) = taken.first() else { return Vec::new() };
    let mut least = least.clone();
    loop {
        let with = |scores: &[f64]| lesser(&least, scores).iter().sum::<f64>();
        let best =
            (0..others.len()).min_by(|&a, &b| with(&others[a].0).total_cmp(&with(&others[b].0)));
        let Some(best) = best else { break };
        if (1.0 + EARNS.get()) * with(&others[best].0) >= least.iter().sum() {
            break;
        }
        least = lesser(&least, &others[best].0);
        taken.push(others.swap_remove(best));
    }
    if taken.len() == 1 {
        let all = |(_, near): (_, NearJoints)| near.listening(&each.outputs, poses, features);
        return taken.into_iter().map(all).collect();
    }
    let owner = |proxy: usize| {
        let lists = 0..taken.len();
        lists.min_by(|&a, &b| taken[a].0[proxy].total_cmp(&taken[b].0[proxy])).unwrap_or(0)
    };
    let owners: Vec<usize> = (0..least.len()).map(owner).collect();
    let of_list = |(list, (_, near)): (usize, (Vec<f64>, NearJoints))| {
        let outputs = each.of(|proxy| owners[proxy] == list);
        if outputs.all.ncols() == 0 {
            return None;
        }
        Some(near.fitted(&outputs, width)?.listening(&outputs, poses, features))
    };
    taken.into_iter().enumerate().filter_map(of_list).collect()
}

/// Sets of joints that a list of a joint may name, with their hops: those near it, on all sides or on one.
fn sets(parents: &[Option<usize>], joint: usize) -> Vec<(usize, Vec<usize>)> {
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
    sets
}

/// The lesser of two numbers of each proxy.
fn lesser(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a.min(*b)).collect()
}

/// Says of each proxy which of its joint's lists predicts it best.
pub fn assign(target: &CorrectionTarget<'_>, known: &Known) -> Vec<usize> {
    let groups = groups(target.dominant.len(), |proxy| target.dominant[proxy]);
    let of_joint = |proxies: Range<usize>| -> Vec<usize> {
        let len = proxies.len();
        let lists = known.get(&target.dominant[proxies.start]).map_or(&[][..], Vec::as_slice);
        if lists.len() < 2 {
            return vec![0; len];
        }
        let each = EachOutputs::new(target, proxies);
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
