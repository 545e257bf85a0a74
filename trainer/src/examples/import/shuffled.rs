//! Whether posed meshes would lie on a scene's joints if their vertices had another order.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::align::{Similarity, carry, diagonal, radius, scaled_turns};
use crate::examples::Matrix3x4;
use crate::examples::sample::spread;

/// Posed vertices, rest vertices and frames that are looked at.
const SAMPLE: (usize, usize, usize) = (12, 4000, 5);
/// How near one joint must carry some vertex to the posed one, over the diagonal.
const NEAR: f64 = 0.02;
/// Posed meshes may be so many times larger or smaller than the rest mesh, in one unit.
const STRETCHED: f64 = 1.5;

/// Tells whether posed meshes, frame-major, turned by right angles and in another unit or not, consist of vertices of
/// the rest mesh that joints carry, each where another one should be. Most vertices must be so in most frames: a frame
/// that exploded tells nothing of the order.
pub(crate) fn is_shuffled(rest: &[[f64; 3]], transforms: &[Matrix3x4], posed: &[[f64; 3]]) -> bool {
    let frame_len = posed.len() / rest.len().max(1);
    let joint_len = transforms.len() / frame_len.max(1);
    let frames = spread(frame_len, SAMPLE.2);
    if frames.is_empty() || rest.is_empty() {
        return false;
    }
    let mut radii: Vec<f64> =
        frames.iter().map(|frame| radius(&posed[frame * rest.len()..][..rest.len()])).collect();
    radii.sort_by(f64::total_cmp);
    let ratio = radius(rest) / radii[radii.len() / 2];
    let likely = |place: &Similarity| {
        let stretch = place.scale() / ratio;
        (1.0 / STRETCHED..STRETCHED).contains(&stretch)
    };
    // The way of each vertex with each joint.
    let way = |v: usize, joint: usize| -> Vec<Vector3<f64>> {
        frames.iter().map(|frame| carry(&transforms[frame * joint_len + joint], &rest[v])).collect()
    };
    let ways = |v: usize| (0..joint_len).map(move |joint| (v, joint));
    let all: Vec<Vec<Vector3<f64>>> = spread(rest.len(), SAMPLE.1)
        .into_iter()
        .flat_map(ways)
        .map(|(v, joint)| way(v, joint))
        .collect();
    let picked = spread(rest.len(), SAMPLE.0);
    let own: Vec<Vec<Vec<Vector3<f64>>>> =
        picked.iter().map(|&v| ways(v).map(|(v, joint)| way(v, joint)).collect()).collect();
    let near = NEAR * diagonal(rest);
    let goes = |place: &Similarity, k: usize, ways: &[Vec<Vector3<f64>>]| {
        let at = |frame: &usize| place.point(posed[frame * rest.len() + picked[k]].into());
        let there: Vec<Vector3<f64>> = frames.iter().map(at).collect();
        ways.iter().any(|way| {
            let near = way.iter().zip(&there).filter(|(a, b)| (*a - *b).norm() < near);
            2 * near.count() > frames.len()
        })
    };
    let most = |goes: &dyn Fn(usize) -> bool| {
        2 * (0..picked.len()).filter(|&k| goes(k)).count() > picked.len()
    };
    let places: Vec<Similarity> = scaled_turns().filter(likely).collect();
    places.par_iter().any(|place| most(&|k| goes(place, k, &all)))
        && !places.iter().any(|place| most(&|k| goes(place, k, &own[k])))
}
