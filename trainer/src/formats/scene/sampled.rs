//! A rigged character as a scene file holds it.

use super::clip::Clip;
use crate::formats::warning::FormatWarning;
use crate::mesh::EngineMesh;
use nalgebra::Matrix4;
use sinew_runtime::format::Space;
use std::ops::Range;

/// A rigged character, sampled: what the readers of scenes return.
pub(crate) struct SampledScene {
    /// Rest positions, V, in the space in which the joints are bound.
    pub(crate) rest: Vec<[f64; 3]>,
    /// Vertex numbers of each triangle.
    pub(crate) triangles: Vec<[usize; 3]>,
    /// The vertices that an engine draws it with, where corners of one differ or anything is authored.
    pub(crate) engine: Option<EngineMesh>,
    /// The meshes that were joined, by name; none where there is one.
    pub(crate) ranges: Vec<(String, Range<usize>)>,
    /// Joint weights of the skins, V x J, vertex-major; none without a skin.
    pub(crate) joint_weights: Option<Vec<f64>>,
    /// Axes and unit of the scene.
    pub(crate) space: Space,
    /// J names.
    pub(crate) names: Vec<String>,
    /// Parent of each joint; several may have none.
    pub(crate) parents: Vec<Option<usize>>,
    /// World frame of each joint where the rest mesh is bound, J.
    pub(crate) binds: Vec<Matrix4<f64>>,
    /// World frame of each joint in each frame, N x J, frame-major.
    pub(crate) frames: Vec<Matrix4<f64>>,
    /// Posed positions as the file itself shows them, N x V; none without a skin, or where they are not
    /// wanted.
    pub(crate) shapes: Option<Vec<[f64; 3]>>,
    /// Whether blendshapes move in them: without, they are plain LBS.
    pub(crate) morphs: bool,
    /// The clips that the frames come from.
    pub(crate) clips: Vec<Clip>,
    /// What was left out.
    pub(crate) warnings: Vec<FormatWarning>,
}
