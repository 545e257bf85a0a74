//! Scenes: rigged characters and their clips, from any format.

mod clip;
mod names;
mod played;

pub use clip::{Clip, RATES};
pub(crate) use clip::{EVEN, RATE, Sampling};
pub use names::JointNames;
pub(crate) use names::mismatch;
pub(super) use names::unique_names;
pub(super) use played::{MovingJoints, Sample, samples};

use super::error::FormatWarning;
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
    /// World frame of each joint in each frame, N x J, frame-major.
    pub(crate) frames: Vec<Matrix4<f64>>,
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
    /// [`SceneError::OtherJoints`]: no node is a joint of the character.
    pub(in crate::formats) fn find<'a>(
        candidates: impl Iterator<Item = (usize, &'a str)>,
        character: &[String],
        names: &JointNames<'_>,
    ) -> Result<Self, SceneError> {
        let candidates: Vec<(usize, String)> =
            candidates.map(|(node, name)| (node, names.renamed(name, character))).collect();
        let node = |name: &String| {
            let found = candidates.iter().find(|(_, own)| own == name);
            found.map(|&(node, _)| node)
        };
        let (of, nodes): (Vec<usize>, Vec<usize>) = character
            .iter()
            .enumerate()
            .filter_map(|(joint, name)| Some((joint, node(name)?)))
            .unzip();
        let found: Vec<String> = candidates.iter().map(|(_, name)| name.clone()).collect();
        let mismatch = mismatch(character, &found);
        if nodes.is_empty() {
            let joints = character.to_vec();
            return Err(SceneError::OtherJoints { joints, mismatch });
        }
        Ok(Self { nodes, of, mismatch })
    }
}

/// Returns the bind frame of a joint. A joint without a skin moves rigidly with its nearest skinned ancestor, or else
/// with any skinned joint, from the pose without animation.
///
/// - `upwards`: the joint and the nodes above it.
/// - `binds`, `at_rest`: world frames of all nodes, as skins bind them and without animation.
pub(in crate::formats) fn bound(
    upwards: impl Iterator<Item = usize> + Clone,
    binds: &[Option<Matrix4<f64>>],
    at_rest: &[Matrix4<f64>],
) -> Option<Matrix4<f64>> {
    let joint = upwards.clone().next()?;
    let any = binds.iter().position(Option::is_some);
    let known = { upwards }.find(|&node| binds[node].is_some()).or(any)?;
    if known == joint {
        return binds[joint];
    }
    Some(binds[known]? * at_rest[known].try_inverse()? * at_rest[joint])
}

/// Reasons why a scene cannot be read as a rigged character.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file is not glTF 2.0.
    #[error("is no glTF 2.0: {reason}")]
    NotGltf {
        /// Message of the parser.
        reason: String,
    },
    /// The file is truncated.
    #[error(
        "is cut short: expected at least {expected} bytes, found {found}; export it, or copy it, again"
    )]
    CutShort {
        /// Bytes that the file should have.
        expected: usize,
        /// Bytes of the file.
        found: usize,
    },
    /// The file is damaged, or not FBX.
    #[error("is no FBX file that can be read: {reason}; export it again as binary FBX")]
    Fbx {
        /// Message of the reader.
        reason: String,
    },
    /// The file requires an extension of glTF that is not supported.
    #[error(
        "needs the glTF extension {name}, which is not read: export without compression, and without \
         instancing"
    )]
    Extension {
        /// The extension.
        name: String,
    },
    /// A buffer of a glTF file is missing or too short.
    #[error("buffer {buffer}: {reason}")]
    Buffer {
        /// Index of the buffer.
        buffer: usize,
        /// The fault.
        reason: String,
    },
    /// An image of a glTF file is missing, or of a kind that glTF does not know.
    #[error("image {image}: {reason}")]
    Image {
        /// Index of the image.
        image: usize,
        /// The fault.
        reason: String,
    },
    /// An accessor of a glTF file does not fit its use or its buffer.
    #[error("accessor {accessor} {reason}")]
    Accessor {
        /// Index of the accessor.
        accessor: usize,
        /// The fault.
        reason: String,
    },
    /// Two counts that must agree differ.
    #[error("{place}: expected {expected} {what}, found {found}")]
    Count {
        /// Place in the file.
        place: String,
        /// Name of the counted items.
        what: &'static str,
        /// Expected count.
        expected: usize,
        /// Count found.
        found: usize,
    },
    /// An index refers to an item that does not exist.
    #[error("{place} names {what} {found} of {len}")]
    NoSuch {
        /// Place in the file.
        place: String,
        /// Kind of the item.
        what: &'static str,
        /// The index.
        found: usize,
        /// Number of items.
        len: usize,
    },
    /// The nodes do not form a tree.
    #[error("node {node} has two parents or is its own ancestor")]
    NoTree {
        /// The node.
        node: String,
    },
    /// The default scene has no node.
    #[error(
        "is empty: its scene shows no node; export the character's mesh and armature, in the scene that the file shows"
    )]
    Empty,
    /// The file has no mesh of triangles.
    #[error("holds no mesh: export the character's mesh together with its armature")]
    NoMesh,
    /// No mesh has shapes.
    #[error("has no blendshape: export the face with its shape keys (morph targets)")]
    NoShapes,
    /// A mesh consists of something other than triangles.
    #[error("mesh {mesh} is made of {mode}: export it as triangles")]
    NoTriangles {
        /// The mesh.
        mesh: String,
        /// Kind of primitives that the mesh consists of.
        mode: String,
    },
    /// A vertex has no joint weight.
    #[error(
        "mesh {mesh}: vertex {vertex} has no joint weight: assign every vertex to a joint before \
         exporting, or give the posed meshes as --targets"
    )]
    Unbound {
        /// The mesh.
        mesh: String,
        /// The vertex.
        vertex: usize,
    },
    /// A joint weight is not finite.
    #[error(
        "mesh {mesh}: vertex {vertex} has the joint weight {number}, expected a finite number: normalize the weights and \
         export again"
    )]
    Weight {
        /// The mesh.
        mesh: String,
        /// The vertex.
        vertex: usize,
        /// The weight.
        number: f64,
    },
    /// No mesh is bound to joints.
    #[error(
        "no mesh has a skin, so there are no joints to learn from: bind the mesh to its armature and \
         export with skinning; posed meshes alone serve as --targets of a scene that has one"
    )]
    NoSkin,
    /// The scene has no joint.
    #[error(
        "has no joint: no skin names one and no node is a bone; export the skeleton with the mesh, \
         and in Blender its armature too"
    )]
    NoJoint,
    /// A mesh has more than one skin.
    #[error("mesh {mesh} has {found} skins, expected one; bake them into one skin cluster")]
    SeveralSkins {
        /// The mesh.
        mesh: String,
        /// Number of skins.
        found: usize,
    },
    /// A skin has no joint.
    #[error("the skin of mesh {mesh} has no joint; bind it again, or export its joints with it")]
    EmptySkin {
        /// The mesh.
        mesh: String,
    },
    /// A constraint drives a joint that has no keys.
    #[error(
        "joint {joint} has no keys but a constraint, {constraint}, which is not evaluated; bake the \
         animation of the joints to keys at every frame"
    )]
    Constrained {
        /// The joint, or the node above a joint.
        joint: String,
        /// The constraint.
        constraint: String,
    },
    /// The bind matrix of a joint has no inverse.
    #[error("the bind matrix of joint {joint} cannot be inverted: bind the mesh again")]
    SingularBind {
        /// The joint.
        joint: String,
    },
    /// Two meshes bind a joint at different places.
    #[error(
        "mesh {mesh} binds joint {joint} elsewhere than the other meshes do: export all meshes in one \
         rest pose (apply the armature's pose as rest pose)"
    )]
    OtherBind {
        /// The mesh.
        mesh: String,
        /// The joint.
        joint: String,
    },
    /// No node is a joint of the character.
    #[error(
        "has none of the character's joints, by name: {}{}",
        joints.join(", "),
        mismatch.as_ref().map_or(String::new(), |mismatch| format!("; {mismatch}"))
    )]
    OtherJoints {
        /// Joints of the character.
        joints: Vec<String>,
        /// Explains why the names do not match, and names the option that helps.
        mismatch: Option<String>,
    },
    /// The file has no animation.
    #[error("holds no animation: export the poses as keys of an animation clip")]
    NoAnimation,
    /// No animation plays a morph target, and no mesh has a skin.
    #[error(
        "has neither a skin nor morph targets that an animation plays, and so no shapes to learn: export the shapes' keys \
         with the animation, or give the posed meshes as .abc, .pc2, .mdd, .npz or numbered .obj"
    )]
    StillShapes,
    /// No clip moves a joint or a shape of the mesh.
    #[error(
        "no animation targets a joint or a shape of the mesh (clips: {}): export the armature's \
         animation, sampled at every frame",
        clips.join(", ")
    )]
    NothingMoves {
        /// The clips of the file.
        clips: Vec<String>,
    },
    /// A requested clip does not exist.
    #[error("has no clip {name}, there are: {}", known.join(", "))]
    UnknownClip {
        /// The requested name.
        name: String,
        /// The clips of the file.
        known: Vec<String>,
    },
    /// Key times are not finite, not in order, or too far apart to sample.
    #[error(
        "clip {clip}: its key times are not finite, not ascending, or span more frames than can be sampled"
    )]
    KeyTimes {
        /// The clip.
        clip: String,
    },
}
