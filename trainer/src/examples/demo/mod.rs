//! The demo character: a procedural arm with a shoulder and half a chest. No linear blend reproduces its flesh. The
//! demo needs no file, and the same options give the same bits everywhere.
//!
//! The skin is a loft of sections along the arm (`shape`). The joints move through smooth random clips; muscles swell
//! the skin, and every point follows each joint by a share of its rotation that varies smoothly over the skin
//! (`motion`). Lengths are in metres, y is up, z is forward. The arm is the left arm and points along x.

mod motion;
mod shape;

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::examples::data::translation;
use crate::examples::{Examples, Skeleton, Split};
use crate::mesh::EngineMesh;
use motion::{Flesh, MotionClip, Pose};
use shape::Skin;

/// Size and seed of the demo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DemoOptions {
    /// Approximate number of vertices, at least 200; the shape does not depend on it.
    pub vertices: usize,
    /// Number of training frames.
    pub poses: usize,
    /// Number of held-out frames, from separate clips.
    pub held_out: usize,
    /// Seed of the poses.
    pub seed: u64,
}

impl Default for DemoOptions {
    fn default() -> Self {
        Self { vertices: 2000, poses: 120, held_out: 40, seed: 1 }
    }
}

/// Generates the demo character's examples.
///
/// Training and held-out frames are smooth clips of up to ten frames over the same ranges of motion. Held-out clips are
/// spread among the training clips. Without training frames the result is invalid, and [`Examples::validate`] says so.
pub fn demo(options: &DemoOptions) -> Examples {
    let skin = Skin::new(options.vertices);
    let flesh: Vec<Flesh> = skin.points.iter().map(Flesh::new).collect();
    let clips = motion::clips(options.poses, options.held_out, options.seed);
    let frames: Vec<(Split, Pose)> = clips.iter().flat_map(MotionClip::frames).collect();

    let rest: Vec<[f64; 3]> = skin.points.iter().map(|point| single(point.position)).collect();
    let mut vertices = vec![[0.0; 3]; frames.len() * rest.len()];
    vertices.par_chunks_mut(rest.len()).zip(&frames).for_each(|(positions, (_, pose))| {
        for (position, flesh) in positions.iter_mut().zip(&flesh) {
            *position = single(flesh.posed(pose));
        }
    });
    Examples {
        engine: Some(EngineMesh::of_vertices(&rest, &skin.triangles, &skin.uv)),
        rest,
        triangles: skin.triangles,
        skeleton: skeleton(),
        vertices,
        transforms: frames.iter().flat_map(|(_, pose)| pose.maps()).collect(),
        split: frames.iter().map(|(split, _)| *split).collect(),
        clip_starts: vec![0],
        ..Examples::default()
    }
}

/// Rounds a position to single precision, as a file does. The arm is regular, so some choices of a fit tie; rounding
/// later would break the ties differently.
fn single(position: Vector3<f64>) -> [f64; 3] {
    position.map(|x| f64::from(x as f32)).into()
}

/// Returns the skeleton, parents before children.
fn skeleton() -> Skeleton {
    Skeleton {
        names: shape::JOINTS.iter().map(|&name| name.to_owned()).collect(),
        parents: (0..shape::JOINTS.len()).map(|joint| joint.checked_sub(1)).collect(),
        rest: shape::origins().iter().map(|&origin| translation(origin.into())).collect(),
        ..Skeleton::default()
    }
}

#[cfg(test)]
mod tests;
