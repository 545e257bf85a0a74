//! Clips: selects the requested clips, checks their rate, and finds the order in which posed meshes follow them.

use super::align::{Path, Similarity, paths, scaled_turns, squared};
use crate::Error;
use crate::examples::{Clip, Examples, spread};
use crate::formats::scene::{EVEN, Sampling};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Most clips for which all orders are tried.
const CLIPS_MOST: usize = 6;
/// Sampled vertices, and sampled frames per clip.
const SAMPLE: (usize, usize) = (60, 6);
/// Meshes are in order if their mean distance from one-joint skinning is below this fraction of the diagonal.
const FITS: f64 = 0.002;
/// Largest residual of another order relative to the given order, and relative to the second-best order.
const BETTER: f64 = 0.4;

/// Selects the requested clips. Also returns their frames among all frames; `None` if every clip is requested.
pub(super) fn selected(
    clips: Vec<Clip>,
    sampling: &Sampling<'_>,
) -> (Vec<Clip>, Option<Vec<usize>>) {
    if clips.iter().all(|clip| sampling.takes(&clip.name)) {
        return (clips, None);
    }
    let mut frames = Vec::new();
    let takes = |clip: &Clip| sampling.takes(&clip.name);
    let taken = clips.into_iter().filter(takes).map(|clip| {
        let first = frames.len();
        frames.extend(clip.first..clip.first + clip.times.len());
        Clip { first, ..clip }
    });
    (taken.collect(), Some(frames))
}

/// Keeps the rows of selected frames, `each` rows per frame; all rows for `None`.
pub(super) fn selected_rows<T: Copy>(all: Vec<T>, each: usize, frames: Option<&[usize]>) -> Vec<T> {
    let Some(frames) = frames else { return all };
    frames.iter().flat_map(|&frame| &all[frame * each..][..each]).copied().collect()
}

/// Checks that the frames of every clip are evenly spaced in time, as in a point cache.
///
/// # Errors
/// A clip has uneven steps; the message has the step that differs most.
pub(super) fn check_even(clips: &[Clip]) -> Result<(), Error> {
    for clip in clips {
        let steps = || clip.times.windows(2).map(|pair| pair[1] - pair[0]);
        let mut sorted: Vec<f64> = steps().collect();
        sorted.sort_by(f64::total_cmp);
        let Some(&usual) = sorted.get(sorted.len() / 2) else { continue };
        let worst = steps()
            .enumerate()
            .max_by(|(_, a), (_, b)| (a - usual).abs().total_cmp(&(b - usual).abs()));
        let Some((frame, step)) = worst else { continue };
        if (step - usual).abs() > EVEN * usual {
            let (name, at) = (&clip.name, clip.times[frame]);
            return Err(Error::value(format!(
                "clip {name} has non-uniform key times: a step of {step:.4} s at {at:.4} s, elsewhere {usual:.4} s; \
                 bake a key at every frame when exporting, or give the frames a second that the meshes were exported \
                 at as --fps"
            )));
        }
    }
    Ok(())
}

/// Counts the frames of clips.
pub(super) fn frame_len(clips: &[Clip]) -> usize {
    clips.iter().map(|clip| clip.times.len()).sum()
}

/// An order of the clips that fits the meshes better than the given order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Order {
    /// Clip numbers in the order of their meshes.
    pub(crate) clips: Vec<usize>,
    /// Mean distance of vertices from one-joint skinning, in this order and in the given order, in % of the diagonal.
    pub(crate) percent: [f64; 2],
    /// Whether the second-best order fits nearly as well.
    pub(crate) is_one_of_several: bool,
}

/// Returns the first frame of each clip's meshes, by clip number.
fn begins(order: &[usize], clips: &[Clip]) -> Vec<usize> {
    let mut begins = vec![0; clips.len()];
    let mut begin = 0;
    for &clip in order {
        begins[clip] = begin;
        begin += clips[clip].times.len();
    }
    begins
}

impl Order {
    /// Lists the frames of the meshes in the clips' order.
    pub(super) fn frames(&self, clips: &[Clip]) -> Vec<usize> {
        let blocks = begins(&self.clips, clips).into_iter().zip(clips);
        blocks.flat_map(|(begin, clip)| begin..begin + clip.times.len()).collect()
    }
}

/// Finds the order in which the meshes follow the clips. `None` if the given order fits, if no order is much better, or
/// if the clips do not cover the frames.
///
/// - `placed`: whether the meshes share the joints' axes and unit. Otherwise right-angle rotations and changes of unit
///   are tried.
pub(crate) fn best_order(examples: &Examples, clips: &[Clip], placed: bool) -> Option<Order> {
    let cover = frame_len(clips) * examples.vertex_len() == examples.vertices.len();
    if !cover || !(2..=CLIPS_MOST).contains(&clips.len()) {
        return None;
    }
    let orders = orders(clips.len());
    let begins = |order: &Vec<usize>| begins(order, clips);
    let given = begins(&orders[0]);
    let fit = Fit::new(examples, clips, &given);
    let places: Vec<Similarity> =
        if placed { vec![Similarity::IDENTITY] } else { scaled_turns().collect() };
    let of_given = |place: &Similarity| {
        let blocks = given.iter().enumerate().map(|(clip, &begin)| fit.block(clip, begin, place));
        fit.residual(&blocks.collect::<Vec<_>>())
    };
    let best_given = places.par_iter().map(of_given).reduce(|| f64::INFINITY, f64::min);
    if best_given < FITS {
        return None;
    }
    // If the meshes of the first clip fit somewhere, some order fits all clips.
    let mut pairs: Vec<(usize, usize)> =
        orders.iter().flat_map(|order| begins(order).into_iter().enumerate()).collect();
    pairs.sort_unstable();
    pairs.dedup();
    let nearest = |place: &Similarity| {
        let first = pairs.iter().filter(|(clip, _)| *clip == 0);
        let residuals = first.map(|&(clip, begin)| fit.residual(&[fit.block(clip, begin, place)]));
        residuals.fold(f64::INFINITY, f64::min)
    };
    let scored: Vec<f64> = places.par_iter().map(nearest).collect();
    let (place, _) = places.iter().zip(scored).min_by(|a, b| a.1.total_cmp(&b.1))?;
    let blocks = pairs.par_iter().map(|&pair| (pair, fit.block(pair.0, pair.1, place)));
    let blocks: BTreeMap<_, Block> = blocks.collect();
    let residual = |order: &Vec<usize>| {
        let own = begins(order).into_iter().enumerate();
        fit.residual(&own.filter_map(|pair| blocks.get(&pair)).collect::<Vec<_>>())
    };
    let mut scored: Vec<(f64, &Vec<usize>)> =
        orders.iter().map(|order| (residual(order), order)).collect();
    scored.sort_by(|a, b| a.0.total_cmp(&b.0));
    let &(best, clips) = scored.first()?;
    if *clips == orders[0] || best > BETTER * best_given {
        return None;
    }
    let is_one_of_several = scored.get(1).is_some_and(|(next, _)| best > BETTER * next);
    let percent = [100.0 * best, 100.0 * best_given];
    Some(Order { clips: clips.clone(), percent, is_one_of_several })
}

/// Residuals of skinning each vertex by its best joint.
struct Fit<'a> {
    examples: &'a Examples,
    vertices: Vec<usize>,
    /// Sampled frames of each clip, relative to the clip's start.
    frames: Vec<Vec<usize>>,
    /// Paths under each joint alone, over the sampled frames: clips x vertices x joints.
    carried: Vec<Vec<Vec<Path>>>,
    diagonal: f64,
}

/// Sum over frames of squared distances, vertices x joints; and the number of frames.
struct Block(Vec<f64>, usize);

impl<'a> Fit<'a> {
    /// Samples vertices and frames, and carries the vertices by the joints.
    ///
    /// - `begins`: first frame of each clip.
    fn new(examples: &'a Examples, clips: &[Clip], begins: &[usize]) -> Self {
        let vertices = spread(examples.vertex_len(), SAMPLE.0);
        let frames: Vec<_> = clips.iter().map(|clip| spread(clip.times.len(), SAMPLE.1)).collect();
        let of_clip = |(frames, begin): (&Vec<usize>, &usize)| {
            let frames: Vec<usize> = frames.iter().map(|frame| begin + frame).collect();
            vertices.iter().map(|&v| paths(examples, &frames, v)).collect()
        };
        let carried = frames.iter().zip(begins).map(of_clip).collect();
        let diagonal = examples.diagonal().max(f64::MIN_POSITIVE);
        Self { examples, vertices, frames, carried, diagonal }
    }

    /// Measures the meshes from frame `begin` on against the poses of a clip.
    fn block(&self, clip: usize, begin: usize, place: &Similarity) -> Block {
        let frames: Vec<usize> = self.frames[clip].iter().map(|frame| begin + frame).collect();
        let squares = self.vertices.iter().zip(&self.carried[clip]).flat_map(|(&v, paths)| {
            let there = place.path(self.examples, &frames, v);
            paths.iter().map(move |path| squared(path, &there))
        });
        Block(squares.collect(), frames.len())
    }

    /// Returns the residual of the best joint of each vertex over some blocks: RMS over frames, mean over vertices,
    /// relative to the diagonal.
    fn residual(&self, blocks: &[impl std::borrow::Borrow<Block>]) -> f64 {
        let frame_len: usize = blocks.iter().map(|block| block.borrow().1).sum();
        let pair_len = blocks.iter().map(|block| block.borrow().0.len()).max().unwrap_or(0);
        let vertex_len = self.vertices.len().max(1);
        let sum = |pair: usize| blocks.iter().map(|block| block.borrow().0[pair]).sum::<f64>();
        let sums: Vec<f64> = (0..pair_len).map(sum).collect();
        let least = sums.chunks((pair_len / vertex_len).max(1));
        let least = least.map(|own| own.iter().copied().fold(f64::INFINITY, f64::min));
        let mean = least.map(f64::sqrt).sum::<f64>() / vertex_len as f64;
        mean / (frame_len.max(1) as f64).sqrt() / self.diagonal
    }
}

/// Lists the permutations of 0..len, the identity first.
fn orders(len: usize) -> Vec<Vec<usize>> {
    let mut orders = vec![Vec::new()];
    for _ in 0..len {
        let longer = |order: &Vec<usize>| -> Vec<Vec<usize>> {
            let others = (0..len).filter(|next| !order.contains(next));
            others.map(|next| order.iter().copied().chain([next]).collect()).collect()
        };
        orders = orders.iter().flat_map(longer).collect();
    }
    orders
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_uneven_step_is_named() {
        let clip = |times: &[f64]| Clip {
            name: "run".into(),
            first: 0,
            times: times.to_vec(),
            numbers: None,
        };
        assert!(check_even(&[clip(&[0.0, 0.1, 0.2, 0.3]), clip(&[0.0]), clip(&[])]).is_ok());
        let error = check_even(&[clip(&[0.0, 0.1, 0.2, 0.4, 0.5])]).unwrap_err();
        let words = "clip run has non-uniform key times: a step of 0.2000 s at 0.2000 s, elsewhere 0.1000 s; ";
        assert!(error.message().starts_with(words), "{error}");
    }
}
