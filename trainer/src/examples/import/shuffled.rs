//! Whether posed meshes would lie on a scene's joints if their vertices had another order.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::align::{Similarity, carry, diagonal, radius, scaled_turns};
use crate::examples::Matrix3x4;
use crate::examples::sample::spread;

/// Posed vertices, rest vertices and frames that are looked at.
const SAMPLE: (usize, usize, usize) = (12, 4000, 4);
/// Nearest that one joint must carry some vertex to the median posed one, over the diagonal.
const NEAR: f64 = 0.02;
/// Posed meshes may be so many times larger or smaller than the rest mesh, in one unit.
const STRETCHED: f64 = 1.5;

/// Tells whether posed meshes, frame-major, turned by right angles and in another unit or not, consist of vertices of
/// the rest mesh that joints carry, each where another one should be.
pub(crate) fn is_shuffled(rest: &[[f64; 3]], transforms: &[Matrix3x4], posed: &[[f64; 3]]) -> bool {
    let frame_len = posed.len() / rest.len().max(1);
    let joint_len = transforms.len() / frame_len.max(1);
    let frames = spread(frame_len, SAMPLE.2);
    let (Some(&first), false) = (frames.first(), rest.is_empty()) else { return false };
    let own = &posed[first * rest.len()..][..rest.len()];
    let ratio = radius(rest) / radius(own);
    let likely = |place: &Similarity| {
        let stretch = place.scale() / ratio;
        (1.0 / STRETCHED..STRETCHED).contains(&stretch)
    };
    // The way of each vertex with each joint.
    let carried: Vec<Vec<Vector3<f64>>> = spread(rest.len(), SAMPLE.1)
        .into_iter()
        .flat_map(|v| (0..joint_len).map(move |joint| (v, joint)))
        .map(|(v, joint)| {
            frames
                .iter()
                .map(|frame| carry(&transforms[frame * joint_len + joint], &rest[v]))
                .collect()
        })
        .collect();
    let picked = spread(rest.len(), SAMPLE.0);
    let left = |place: Similarity| {
        let of_vertex = |&v: &usize| {
            let there: Vec<Vector3<f64>> = frames
                .iter()
                .map(|frame| place.point(posed[frame * rest.len() + v].into()))
                .collect();
            let squares = carried.iter().map(|carried| {
                carried.iter().zip(&there).map(|(a, b)| (a - b).norm_squared()).sum::<f64>()
            });
            squares.fold(f64::INFINITY, f64::min)
        };
        let mut left: Vec<f64> = picked.iter().map(of_vertex).collect();
        left.sort_by(f64::total_cmp);
        (left[left.len() / 2] / frames.len() as f64).sqrt()
    };
    let places: Vec<Similarity> = scaled_turns().filter(likely).collect();
    let near = NEAR * diagonal(rest);
    places.into_par_iter().any(|place| left(place) < near)
}
