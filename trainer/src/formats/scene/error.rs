//! What keeps a scene from being read, and what to export instead.

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
