//! What keeps a scene from becoming examples, and what to export instead.

/// A scene, or the posed meshes beside it, that cannot become examples.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The file's name does not end as any format that is read here.
    #[error("expected a file that ends in {expected}, found {found}")]
    UnknownFormat {
        /// The endings that are read.
        expected: &'static str,
        /// The ending found.
        found: String,
    },
    /// What only goes with a scene was given with examples that are complete.
    #[error(
        "{option} goes with a scene (.glb, .gltf, .fbx); an .npz holds its own poses and meshes"
    )]
    NotAScene {
        /// What was given.
        option: &'static str,
    },
    /// The file is no glTF 2.0.
    #[error("is no glTF 2.0: {reason}")]
    NotGltf {
        /// What the parser says.
        reason: String,
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
    /// There is no mesh of triangles.
    #[error("holds no mesh: export the character's mesh together with its armature")]
    NoMesh,
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
         exporting"
    )]
    Unbound {
        /// The mesh.
        mesh: String,
        /// The vertex.
        vertex: usize,
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
    /// There is nothing to sample.
    #[error("holds no animation: export the poses as keys of an animation clip")]
    NoAnimation,
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
    /// Posed meshes follow at one rate, the clip's keys do not.
    #[error(
        "clip {clip} has non-uniform key times: a step of {step:.4} s at {at:.4} s, elsewhere \
         {usual:.4} s; bake a key at every frame when exporting, or give the frames a second that \
         the meshes were exported at as --fps"
    )]
    UnevenKeys {
        /// The clip.
        clip: String,
        /// Where the uneven step begins, in seconds.
        at: f64,
        /// How long it is, in seconds.
        step: f64,
        /// How long the others are, in seconds.
        usual: f64,
    },
    /// There are poses but no meshes to learn.
    #[error(
        "holds poses but neither a skin nor shapes: give the posed meshes as --targets (.pc2, .mdd, \
         .npz, or a numbered sequence of .obj)"
    )]
    NoShapes,
    /// The posed meshes are of another mesh.
    #[error(
        "holds meshes of {found} vertices, the scene's mesh has {expected}: export both from one mesh \
         without modifiers that change its vertices; glTF splits vertices along seams of texture and \
         normals, FBX does not"
    )]
    TargetVertices {
        /// In the scene.
        expected: usize,
        /// In the file.
        found: usize,
    },
    /// There are not as many posed meshes as poses.
    #[error(
        "holds {found} meshes, the scene's clips have {expected} frames ({clips}): export both over \
         the same frames, choose the clip with --clip, or sample it at the meshes' rate with --fps"
    )]
    TargetFrames {
        /// Frames of the clips.
        expected: usize,
        /// Meshes in the file.
        found: usize,
        /// The clips and their frames.
        clips: String,
    },
    /// The rest mesh is another one.
    #[error(
        "its rest mesh is not that of the model in any axes and unit: off by {percent:.1} % of the \
         diagonal at best"
    )]
    OtherMesh {
        /// RMS distance in % of the diagonal.
        percent: f64,
    },
    /// The posed meshes are not where the joints are.
    #[error(
        "its meshes do not lie on the scene's joints in any axes and unit: off by {percent:.0} % of \
         the diagonal at best; export them in world space, and over the same frames as the clip"
    )]
    TargetsApart {
        /// RMS distance from the nearest rigid skin, in % of the diagonal.
        percent: f64,
    },
}

impl ImportError {
    /// Tells whether the posed meshes are at fault, not the scene.
    pub(in crate::examples) fn is_about_targets(&self) -> bool {
        matches!(
            self,
            Self::TargetVertices { .. } | Self::TargetFrames { .. } | Self::TargetsApart { .. }
        )
    }
}
