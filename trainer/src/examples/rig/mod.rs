//! What importers of scene files return, on its way to [`Examples`](super::Examples).

mod error;
mod times;

use nalgebra::Matrix4;

pub use error::ImportError;
pub(super) use times::sample_times;

use super::{Clip, Warning};

/// A rigged character as a scene file holds it, sampled: what an importer of scene files returns.
pub(super) struct Rig {
    /// Rest positions, V, in the space in which the joints are bound.
    pub(super) rest: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[usize; 3]>,
    pub(super) uv: Option<Vec<[f64; 2]>>,
    /// J names.
    pub(super) names: Vec<String>,
    /// Parent of each joint; several may have none.
    pub(super) parents: Vec<Option<usize>>,
    /// World frame of each joint where the rest mesh is bound, J.
    pub(super) binds: Vec<Matrix4<f64>>,
    /// World frame of each joint in each frame, N x J, frame-major.
    pub(super) frames: Vec<Matrix4<f64>>,
    /// Posed positions as the file itself shows them, N x V (skin and blendshapes); none without a skin.
    pub(super) shapes: Option<Vec<[f64; 3]>>,
    /// Whether blendshapes move in them: without, they are plain LBS.
    pub(super) morphs: bool,
    pub(super) clips: Vec<Clip>,
    pub(super) warnings: Vec<Warning>,
}

/// Which frames of a scene file to take.
pub(super) struct Sampling<'a> {
    /// Frames a second; the file's own keys without it.
    pub(super) fps: Option<f64>,
    /// The one clip to take, by name; all of them without it.
    pub(super) clip: Option<&'a str>,
}
