//! In which order posed meshes follow a scene's clips: tools sort clips differently.

use nalgebra::Vector3;
use rayon::prelude::*;
use std::collections::BTreeMap;

use super::align::{Similarity, carry, diagonal, scaled_turns};
use crate::examples::Matrix3x4;
use crate::examples::sample::spread;

/// Most clips whose orders are all tried.
const CLIPS_MOST: usize = 6;
/// Vertices, and frames of each clip, that are looked at.
const SAMPLE: (usize, usize) = (60, 6);
/// Meshes whose vertices one joint each carries within this share of the diagonal, in the mean, are in order.
const FITS: f64 = 0.002;
/// Another order must leave less than this share of what the order given leaves, and of what each further one leaves.
const BETTER: f64 = 0.4;

/// Poses of several clips, and the meshes for them.
pub(crate) struct PosedClips<'a> {
    /// Rest positions, V.
    pub(crate) rest: &'a [[f64; 3]],
    /// Maps of the joints, N x J, frame-major.
    pub(crate) transforms: &'a [Matrix3x4],
    /// Posed positions, N x V, frame-major.
    pub(crate) posed: &'a [[f64; 3]],
    /// Frames of each clip, N in all.
    pub(crate) lens: &'a [usize],
    /// Whether the meshes are where the joints are; else they may be there after a turn by right angles and a change
    /// of units.
    pub(crate) placed: bool,
}

/// Another order than the clips', in which the meshes fit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Order {
    /// The clips in the order of their meshes.
    pub(crate) clips: Vec<usize>,
    /// How far vertices are from where one joint carries them, in this order and in that given, in % of the diagonal.
    pub(crate) percent: [f64; 2],
    /// Whether a further order fits nearly as well.
    pub(crate) is_one_of_several: bool,
}

impl Order {
    /// Lists for each clip where its meshes begin.
    fn begins(clips: &[usize], lens: &[usize]) -> Vec<usize> {
        let mut begins = vec![0; lens.len()];
        let mut begin = 0;
        for &clip in clips {
            begins[clip] = begin;
            begin += lens[clip];
        }
        begins
    }

    /// Sorts what is so much each frame, frame-major, as the clips are.
    pub(super) fn sorted<T: Clone>(&self, all: &[T], each: usize, lens: &[usize]) -> Vec<T> {
        let begins = Self::begins(&self.clips, lens);
        let blocks = begins.into_iter().zip(lens);
        blocks.flat_map(|(begin, len)| &all[begin * each..][..len * each]).cloned().collect()
    }
}

impl PosedClips<'_> {
    /// Finds the order of the clips in which the meshes follow; none where that given is as good as any, where none is
    /// better by far, or where the clips do not cover the frames.
    pub(crate) fn order(&self) -> Option<Order> {
        let len = self.lens.len();
        let cover = self.lens.iter().sum::<usize>() * self.rest.len() == self.posed.len();
        if !cover || !(2..=CLIPS_MOST).contains(&len) {
            return None;
        }
        let fit = Fit::new(self);
        let places: Vec<Similarity> =
            if self.placed { vec![Similarity::IDENTITY] } else { scaled_turns().collect() };
        let orders = orders(len);
        let begins = |order: &Vec<usize>| Order::begins(order, self.lens);
        let given = begins(&orders[0]);
        let of_given = |place: &Similarity| {
            let blocks = given.iter().enumerate();
            fit.left(
                &blocks.map(|(clip, &begin)| fit.block(clip, begin, place)).collect::<Vec<_>>(),
            )
        };
        let best_given = places.par_iter().map(of_given).reduce(|| f64::INFINITY, f64::min);
        if best_given < FITS {
            return None;
        }
        // Where the meshes of the first clip fit somewhere, all do in some order.
        let mut pairs: Vec<(usize, usize)> =
            orders.iter().flat_map(|order| begins(order).into_iter().enumerate()).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let nearest = |place: &Similarity| {
            let first = pairs.iter().filter(|(clip, _)| *clip == 0);
            let left = first.map(|&(clip, begin)| fit.left(&[fit.block(clip, begin, place)]));
            left.fold(f64::INFINITY, f64::min)
        };
        let scored: Vec<f64> = places.par_iter().map(nearest).collect();
        let (place, _) = places.iter().zip(scored).min_by(|a, b| a.1.total_cmp(&b.1))?;
        let blocks: BTreeMap<_, Block> = pairs
            .par_iter()
            .map(|&(clip, begin)| ((clip, begin), fit.block(clip, begin, place)))
            .collect();
        let left = |order: &Vec<usize>| {
            let own = begins(order).into_iter().enumerate();
            fit.left(&own.filter_map(|pair| blocks.get(&pair)).collect::<Vec<_>>())
        };
        let mut scored: Vec<(f64, &Vec<usize>)> =
            orders.iter().map(|order| (left(order), order)).collect();
        scored.sort_by(|a, b| a.0.total_cmp(&b.0));
        let &(best, clips) = scored.first()?;
        if *clips == orders[0] || best > BETTER * best_given {
            return None;
        }
        let is_one_of_several = scored.get(1).is_some_and(|(next, _)| best > BETTER * next);
        let percent = [100.0 * best, 100.0 * best_given];
        Some(Order { clips: clips.clone(), percent, is_one_of_several })
    }
}

/// How well one joint a vertex carries the meshes of a clip.
struct Fit<'a> {
    clips: &'a PosedClips<'a>,
    vertices: Vec<usize>,
    /// The frames of each clip that are looked at, from its first.
    frames: Vec<Vec<usize>>,
    /// Where each joint alone carries each vertex in them, vertex by vertex and in it joint by joint.
    carried: Vec<Vec<Vec<Vector3<f64>>>>,
    diagonal: f64,
}

/// Squared distances that each joint leaves of each vertex, summed over frames, and how many these are.
struct Block(Vec<f64>, usize);

impl<'a> Fit<'a> {
    fn new(clips: &'a PosedClips<'a>) -> Self {
        let vertices = spread(clips.rest.len(), SAMPLE.0);
        let frames: Vec<_> = clips.lens.iter().map(|&len| spread(len, SAMPLE.1)).collect();
        let joint_len = clips.transforms.len() / clips.lens.iter().sum::<usize>().max(1);
        let given: Vec<usize> = (0..clips.lens.len()).collect();
        let begins = Order::begins(&given, clips.lens);
        let of_frame = |frame: usize| -> Vec<Vector3<f64>> {
            let maps = &clips.transforms[frame * joint_len..][..joint_len];
            let of_vertex = |&v: &usize| maps.iter().map(move |map| carry(map, &clips.rest[v]));
            vertices.iter().flat_map(of_vertex).collect()
        };
        let carried = frames.iter().zip(begins);
        let carried = carried
            .map(|(frames, begin)| frames.iter().map(|frame| of_frame(begin + frame)).collect())
            .collect();
        let diagonal = diagonal(clips.rest);
        Self { clips, vertices, frames, carried, diagonal }
    }

    /// Measures the meshes from `begin` on as those of a clip.
    fn block(&self, clip: usize, begin: usize, place: &Similarity) -> Block {
        let mut squares = Vec::new();
        let vertex_len = self.clips.rest.len();
        for (&frame, carried) in self.frames[clip].iter().zip(&self.carried[clip]) {
            squares.resize(carried.len(), 0.0);
            let joint_len = carried.len() / self.vertices.len().max(1);
            let posed = &self.clips.posed[(begin + frame) * vertex_len..][..vertex_len];
            for (number, &v) in self.vertices.iter().enumerate() {
                let there = place.point(posed[v].into());
                let of_vertex = number * joint_len..(number + 1) * joint_len;
                let own = carried[of_vertex.clone()].iter();
                for (square, carried) in squares[of_vertex].iter_mut().zip(own) {
                    *square += (carried - there).norm_squared();
                }
            }
        }
        Block(squares, self.frames[clip].len())
    }

    /// How far the best joint of each vertex leaves it in some blocks, RMS over frames and in the mean over vertices,
    /// over the diagonal.
    fn left(&self, blocks: &[impl std::borrow::Borrow<Block>]) -> f64 {
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

/// Lists the orders of some things, that in which they are first.
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
