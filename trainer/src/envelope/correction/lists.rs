//! Lists of joints for the maps of each joint: one, or several for helpers that hear different ones (METHOD §1.9).

use super::features::{near, neighbours, on_side};
use super::group_outputs::{EachOutputs, groups};
use super::listening::{HOPS, Listening};
use super::target::CorrectionTarget;
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
    let of_joint = |proxies: Range<usize>| {
        let joint = target.dominant[proxies.start];
        let lists = of_joint(target, proxies);
        progress.advance(1);
        (joint, lists)
    };
    groups.into_par_iter().map(of_joint).collect()
}

/// Chooses lists for several proxies of a joint: one for all, and further ones, of fewer or more joints or of those on one
/// side of theirs, as long as what each proxy's best list scores falls by enough. An armpit hears its own arm.
pub(super) fn of_joint(target: &CorrectionTarget<'_>, proxies: Range<usize>) -> Vec<Listening> {
    let joint = target.dominant[proxies.start];
    let each = EachOutputs::new(target, proxies);
    let Some(first) = Listening::near(target, &each.outputs, joint) else { return Vec::new() };
    let mut lists = vec![first.clone()];
    for (hops, joints) in sets(target.features.parents, joint) {
        let inputs = target.features.inputs(target.poses, &joints);
        if lists.iter().all(|known| known.inputs != inputs) {
            lists.push(Listening { hops, inputs, ..first });
        }
    }
    let scores = Scores::new(target, &each, &lists);
    let mut taken = vec![0];
    loop {
        let with = |list: usize| scores.sum(&[&taken[..], &[list]].concat());
        let best = (0..lists.len()).min_by(|&a, &b| with(a).total_cmp(&with(b)));
        match best.filter(|&best| {
            (1.0 + target.features.settings.alike) * with(best) < scores.sum(&taken)
        }) {
            Some(best) => taken.push(best),
            None => break,
        }
    }
    // Of other proxies one may take a list that none of these takes.
    let of_list = |&list: &usize| {
        let outputs = each.of(|proxy| scores.best(&taken, proxy).0 == list);
        outputs
            .and_then(|outputs| lists[list].best(target, &outputs))
            .unwrap_or(lists[list].clone())
    };
    taken.iter().map(of_list).collect()
}

/// How each list predicts each proxy.
struct Scores(Vec<Vec<f64>>);

impl Scores {
    fn new(target: &CorrectionTarget<'_>, each: &EachOutputs, lists: &[Listening]) -> Self {
        let of = |list: &Listening| {
            let scores = list.scores(target, &each.outputs);
            scores.map_or(vec![f64::INFINITY; each.proxy_len], |all| each.by_proxy(&all))
        };
        Self(lists.iter().map(of).collect())
    }

    /// Finds the list among some that predicts a proxy best, and its score.
    fn best(&self, lists: &[usize], proxy: usize) -> (usize, f64) {
        let scores = lists.iter().map(|&list| (list, self.0[list][proxy]));
        scores.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY))
    }

    /// Sums the scores of all proxies, each by its best list.
    fn sum(&self, lists: &[usize]) -> f64 {
        (0..self.0[0].len()).map(|proxy| self.best(lists, proxy).1).sum()
    }
}

/// Sets of joints that a list of a joint may name, with their hops: those near it, on all sides or on one.
fn sets(parents: &[Option<usize>], joint: usize) -> impl Iterator<Item = (usize, Vec<usize>)> {
    HOPS.into_iter().flat_map(move |hops| {
        let all = near(parents, joint, hops);
        let side = |side| on_side(parents, joint, side, &all);
        let sides: Vec<_> = neighbours(parents, joint).map(side).collect();
        std::iter::once(all).chain(sides).map(move |set| (hops, set))
    })
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
        let scores = Scores::new(target, &EachOutputs::new(target, proxies), lists);
        let all: Vec<usize> = (0..lists.len()).collect();
        (0..len).map(|proxy| scores.best(&all, proxy).0).collect()
    };
    groups.into_par_iter().map(of_joint).collect::<Vec<_>>().concat()
}
