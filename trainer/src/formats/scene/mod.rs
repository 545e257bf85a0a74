//! Scenes: rigged characters and their clips, whichever format they come in.
//! A rigged character as a scene file holds it.
//! The motion of a skeleton, whatever it moves.
//! What keeps a scene from being read, and what to export instead.

mod clip;
mod names;
mod played;

pub use clip::{Clip, RATES};
pub(crate) use clip::{EVEN, RATE, Sampling};
pub use names::JointNames;
pub(crate) use names::mismatch;
pub(super) use names::told_apart;
pub(super) use played::{MovingJoints, Sample, samples};

use super::error::FormatWarning;
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

/// How joints move, sampled: what the readers of scenes return of animations without a mesh.
pub(crate) struct Motion {
    /// Axes and unit of the scene.
    pub(crate) space: Space,
    /// The joints of the character that are there.
    pub(crate) joints: MotionJoints,
    /// World frame of each where nothing is animated.
    pub(crate) rest: Vec<Matrix4<f64>>,
    /// Frame in which a skin of the file binds each; none where the file has no skin.
    pub(crate) binds: Option<Vec<Matrix4<f64>>>,
    /// World frame of each in each frame, frame-major.
    pub(crate) frames: Vec<Matrix4<f64>>,
    /// The clips that the frames come from.
    pub(crate) clips: Vec<Clip>,
    /// What was left out.
    pub(crate) warnings: Vec<FormatWarning>,
}

/// Which nodes of a file are joints of a character.
pub(crate) struct MotionJoints {
    /// The nodes.
    pub(crate) nodes: Vec<usize>,
    /// The joint of the character that each is.
    pub(crate) of: Vec<usize>,
    /// What keeps the names of other nodes from matching, and the option that mends it.
    pub(crate) mismatch: Option<String>,
}

impl MotionJoints {
    /// Finds the joints of a character among nodes, each with its name; of several of one name the first.
    ///
    /// # Errors
    /// [`SceneError::OtherJoints`] where there is none.
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

/// Gives the frame in which a joint is bound; of one that no skin names, where it stands against the nearest above that
/// one does.
///
/// - `upwards`: the joint and the nodes above it.
/// - `binds`, `at_rest`: of all nodes, as skins bind them and where nothing is animated.
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

/// A scene that cannot be read, or lacks what a rigged character has.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file is no glTF 2.0.
    #[error("is no glTF 2.0: {reason}")]
    NotGltf {
        /// What the parser says.
        reason: String,
    },
    /// The file ends before it should.
    #[error(
        "is cut short: expected at least {expected} bytes, found {found}; export it, or copy it, again"
    )]
    CutShort {
        /// Bytes that it says it has.
        expected: usize,
        /// Bytes that are there.
        found: usize,
    },
    /// The file is damaged or is no FBX.
    #[error("is no FBX file that can be read: {reason}; export it again as binary FBX")]
    Fbx {
        /// What the reader says.
        reason: String,
    },
    /// The file cannot be read without something that is not in glTF itself.
    #[error(
        "needs the glTF extension {name}, which is not read: export without compression, and without \
         instancing"
    )]
    Extension {
        /// The extension.
        name: String,
    },
    /// A buffer of a glTF file is absent or too short.
    #[error("buffer {buffer}: {reason}")]
    Buffer {
        /// The buffer.
        buffer: usize,
        /// What is wrong.
        reason: String,
    },
    /// An image of a glTF file is absent or of no kind that glTF knows.
    #[error("image {image}: {reason}")]
    Image {
        /// The image.
        image: usize,
        /// What is wrong.
        reason: String,
    },
    /// An accessor of a glTF file does not fit its use or its buffer.
    #[error("accessor {accessor} {reason}")]
    Accessor {
        /// The accessor.
        accessor: usize,
        /// What is wrong.
        reason: String,
    },
    /// Two counts that belong together differ.
    #[error("{place}: expected {expected} {what}, found {found}")]
    Count {
        /// Where.
        place: String,
        /// What is counted.
        what: &'static str,
        /// How many there must be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// Something is named that does not exist.
    #[error("{place} names {what} {found} of {len}")]
    NoSuch {
        /// Where.
        place: String,
        /// What is named.
        what: &'static str,
        /// The number that names it.
        found: usize,
        /// How many there are.
        len: usize,
    },
    /// The nodes are no tree.
    #[error("node {node} has two parents or is its own ancestor")]
    NoTree {
        /// The node.
        node: String,
    },
    /// The scene that the file shows has no node.
    #[error(
        "is empty: its scene shows no node; export the character's mesh and armature, in the scene that the file shows"
    )]
    Empty,
    /// There is no mesh of triangles.
    #[error("holds no mesh: export the character's mesh together with its armature")]
    NoMesh,
    /// No mesh has shapes.
    #[error("has no blendshape: export the face with its shape keys (morph targets)")]
    NoShapes,
    /// A mesh has faces of another kind.
    #[error("mesh {mesh} is made of {mode}: export it as triangles")]
    NoTriangles {
        /// The mesh.
        mesh: String,
        /// What it is made of.
        mode: String,
    },
    /// A vertex follows no joint.
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
        /// How many it has.
        found: usize,
    },
    /// A skin is bound to nothing.
    #[error("the skin of mesh {mesh} has no joint; bind it again, or export its joints with it")]
    EmptySkin {
        /// The mesh.
        mesh: String,
    },
    /// A joint is driven by something else than keys.
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
    /// A joint is bound by a matrix without inverse.
    #[error("the bind matrix of joint {joint} cannot be inverted: bind the mesh again")]
    SingularBind {
        /// The joint.
        joint: String,
    },
    /// Two meshes disagree about where a joint is bound.
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
        /// The character's.
        joints: Vec<String>,
        /// What keeps the names from matching, and the option that mends it.
        mismatch: Option<String>,
    },
    /// There is nothing to sample.
    #[error("holds no animation: export the poses as keys of an animation clip")]
    NoAnimation,
    /// No animation plays a morph target of meshes without a skin.
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
    /// The clip asked for is not there.
    #[error("has no clip {name}, there are: {}", known.join(", "))]
    UnknownClip {
        /// The name asked for.
        name: String,
        /// The clips of the file.
        known: Vec<String>,
    },
    /// Key times are not finite, not in order, or reach too far to sample.
    #[error(
        "clip {clip}: its key times are not finite, not ascending, or span more frames than can be sampled"
    )]
    KeyTimes {
        /// The clip.
        clip: String,
    },
}
