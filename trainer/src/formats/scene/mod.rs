//! Scenes: rigged characters and their clips, from any format.

mod clip;
mod curves;
pub(crate) mod faults;
mod hierarchy;
mod names;
mod played;

pub(super) use clip::Sample;
pub use clip::{Clip, RATES};
pub(crate) use clip::{EVEN, RATE, Sampling};
pub(crate) use curves::CurveTrack;
pub(super) use hierarchy::Hierarchy;
pub use names::JointNames;
pub(crate) use names::mismatch;
pub(super) use played::{MovingJoints, samples};

use super::FormatWarning;
use crate::Error;
use crate::mesh::EngineMesh;
use nalgebra::Matrix4;
use sinew_runtime::format::Space;
use std::ops::Range;

/// A rigged character, sampled, as all readers of scenes return it.
pub(crate) struct SampledScene {
    /// Rest positions, V, in the space in which the joints are bound.
    pub(crate) rest: Vec<[f64; 3]>,
    /// Vertex indices of each triangle.
    pub(crate) triangles: Vec<[usize; 3]>,
    /// Engine vertices, if corners of a vertex differ or attributes are authored.
    pub(crate) engine: Option<EngineMesh>,
    /// Names and vertex ranges of the joined meshes; empty for a single mesh.
    pub(crate) ranges: Vec<(String, Range<usize>)>,
    /// Joint weights of the skins, V x J, vertex-major; `None` without a skin.
    pub(crate) joint_weights: Option<Vec<f64>>,
    /// Axes and unit of the scene.
    pub(crate) space: Space,
    /// Names of the joints, J.
    pub(crate) names: Vec<String>,
    /// Parent of each joint; several joints may have none.
    pub(crate) parents: Vec<Option<usize>>,
    /// World frame of each joint in the bind pose, J.
    pub(crate) binds: Vec<Matrix4<f64>>,
    /// World frame of each joint without animation, J.
    pub(crate) at_rest: Vec<Matrix4<f64>>,
    /// World frame of each joint in each frame, N x J, frame-major.
    pub(crate) frames: Vec<Matrix4<f64>>,
    /// Weights of named shapes of all meshes; empty if they were not requested.
    pub(crate) curves: Vec<CurveTrack>,
    /// Posed positions, N x V, as the file itself poses them; `None` without a skin, or if they were not requested.
    pub(crate) shapes: Option<Vec<[f64; 3]>>,
    /// Whether blendshapes move in `shapes`; otherwise `shapes` are plain LBS.
    pub(crate) morphs: bool,
    /// Clips of the frames.
    pub(crate) clips: Vec<Clip>,
    /// Data that was left out.
    pub(crate) warnings: Vec<FormatWarning>,
}

/// Sampled motion of joints, as readers of scenes return it for animations without a mesh.
pub(crate) struct Motion {
    /// Axes and unit of the scene.
    pub(crate) space: Space,
    /// The joints of the character that the file has.
    pub(crate) joints: MotionJoints,
    /// World frame of each joint without animation.
    pub(crate) rest: Vec<Matrix4<f64>>,
    /// Frame in which a skin of the file binds each joint; `None` if the file has no skin.
    pub(crate) binds: Option<Vec<Matrix4<f64>>>,
    /// World frame of each joint in each frame, frame-major.
    pub(crate) frames: Vec<Matrix4<f64>>,
    /// Weights of named shapes of all meshes; empty if they were not requested.
    pub(crate) curves: Vec<CurveTrack>,
    /// Clips of the frames.
    pub(crate) clips: Vec<Clip>,
    /// Data that was left out.
    pub(crate) warnings: Vec<FormatWarning>,
}

/// The nodes of a file that are joints of a character.
pub(crate) struct MotionJoints {
    /// Indices of the nodes.
    pub(crate) nodes: Vec<usize>,
    /// Joint of the character, for each node.
    pub(crate) of: Vec<usize>,
    /// Explains why the names of other nodes do not match, and names the option that helps.
    pub(crate) mismatch: Option<String>,
}

impl MotionJoints {
    /// Finds the joints of a character among named nodes; the first node with a joint's name counts.
    ///
    /// # Errors
    /// No node is a joint of the character.
    pub(in crate::formats) fn find(
        candidates: Vec<(usize, String)>,
        character: &[String],
        names: &JointNames<'_>,
    ) -> Result<Self, Error> {
        let renamed = |(node, name): (usize, String)| (node, names.renamed(&name, character));
        let candidates: Vec<(usize, String)> = candidates.into_iter().map(renamed).collect();
        let node = |name: &String| {
            let found = candidates.iter().find(|(_, own)| own == name);
            found.map(|&(node, _)| node)
        };
        let found = character.iter().enumerate();
        let found = found.filter_map(|(joint, name)| Some((joint, node(name)?)));
        let (of, nodes): (Vec<usize>, Vec<usize>) = found.unzip();
        let found: Vec<String> = candidates.iter().map(|(_, name)| name.clone()).collect();
        let mismatch = mismatch(character, &found);
        if nodes.is_empty() {
            let mismatch = mismatch.map_or(String::new(), |mismatch| format!("; {mismatch}"));
            return Err(Error::mismatch(format!(
                "has none of the character's joints, by name: {}{mismatch}",
                character.join(", ")
            )));
        }
        Ok(Self { nodes, of, mismatch })
    }
}
