//! The motion of a skeleton, whatever it moves.

use super::clip::Clip;
use crate::formats::warning::FormatWarning;
use nalgebra::Matrix4;
use sinew_runtime::format::Space;

/// How joints move, sampled: what the readers of scenes return of animations without a mesh.
pub(crate) struct Motion {
    /// Axes and unit of the scene.
    pub(crate) space: Space,
    /// Names of the joints that were asked for and are there.
    pub(crate) names: Vec<String>,
    /// World frame of each where nothing is animated.
    pub(crate) rest: Vec<Matrix4<f64>>,
    /// World frame of each in each frame, frame-major.
    pub(crate) frames: Vec<Matrix4<f64>>,
    /// The clips that the frames come from.
    pub(crate) clips: Vec<Clip>,
    /// What was left out.
    pub(crate) warnings: Vec<FormatWarning>,
}
