//! What can be wrong with a file that comes from an animation program.

/// A fault in a scene, a mesh or posed meshes, with what to export instead.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// A clip is asked for that the file does not have.
    #[error("has no clip {name}, but {}", known.join(", "))]
    UnknownClip {
        /// The name asked for.
        name: String,
        /// The names that there are.
        known: Vec<String>,
    },
    /// Keys of a clip do not follow one another evenly, so that they are not its frames.
    #[error(
        "keys of clip {clip} are not even: a step of {step} s at {at} s, of {usual} s elsewhere; \
         bake a key at every frame, or give --fps"
    )]
    UnevenKeys {
        /// The clip.
        clip: String,
        /// When the step begins, in seconds.
        at: f64,
        /// The step, in seconds.
        step: f64,
        /// The step elsewhere, in seconds.
        usual: f64,
    },

    // Posed meshes.
    /// A file of posed meshes has an extension that nothing reads.
    #[error(
        "is no kind of posed meshes that can be read: expected .pc2, .mdd, .npz, one of numbered \
         .obj files or a folder of them, found {found}; export a point cache as .pc2 or .mdd"
    )]
    UnknownTargets {
        /// The extension.
        found: String,
    },
    /// A point cache does not begin as one.
    #[error("is no PointCache2 file of version 1: {reason}; export it as .pc2 again")]
    NotPointCache {
        /// What is different.
        reason: String,
    },
    /// A count in the header of a point cache is not positive.
    #[error("counts {found} {what}, expected 1 at least; export the point cache again")]
    PointCacheCount {
        /// What is counted.
        what: &'static str,
        /// The count.
        found: i32,
    },
    /// A point cache is cut off, or goes on after its end.
    #[error(
        "should have {expected} bytes by its header, found {found}; export the point cache again"
    )]
    PointCacheLength {
        /// Bytes that the header asks for.
        expected: u64,
        /// Bytes that there are.
        found: u64,
    },
    /// A line of an OBJ file cannot be read.
    #[error("line {line} is no vertex, texture coordinate or face of numbers: {text}")]
    ObjLine {
        /// The line, the first being 1.
        line: usize,
        /// Its beginning.
        text: String,
    },
    /// A face of an OBJ file names something that is not there.
    #[error("face {face} names a {what} that is none of the {len} there are")]
    ObjCorner {
        /// The face, the first being 1.
        face: usize,
        /// What it names.
        what: &'static str,
        /// How many there are.
        len: usize,
    },
    /// An OBJ file has no face to build triangles of.
    #[error("has no face of three corners or more; export a polygon mesh")]
    NoFaces,
    /// A folder has no OBJ file.
    #[error(
        "is a folder without an .obj file; export one a frame, numbered: pose_1.obj, pose_2.obj"
    )]
    NoObj,
    /// An OBJ file has no number, so that its frame is not known.
    #[error("has no frame number before .obj; export one file a frame: pose_1.obj, pose_2.obj")]
    NoNumber,
    /// Two OBJ files have one number, so that their order is not known.
    #[error(
        "has the frame number of {other}, {number}; keep one of them, or one sequence a folder"
    )]
    SameNumber {
        /// The number.
        number: u64,
        /// The other file's name.
        other: String,
    },
    /// The meshes of a sequence have different vertices.
    #[error(
        "has {found} vertices, expected {expected} as in {first}; export every frame with the same \
         vertices in the same order"
    )]
    OtherVertices {
        /// Vertices in the file.
        found: usize,
        /// Vertices in the first file.
        expected: usize,
        /// The first file's name.
        first: String,
    },
    /// The meshes of a sequence have different faces.
    #[error(
        "has other faces than {first}, from face {face} on ({found_len} in all, expected \
         {expected_len}); export every frame with the same faces, not triangulated anew"
    )]
    OtherFaces {
        /// The first file's name.
        first: String,
        /// The first face that differs, the first of all being 1.
        face: usize,
        /// Faces in the file.
        found_len: usize,
        /// Faces in the first file.
        expected_len: usize,
    },

    // FBX.
    /// The file is damaged or is no FBX.
    #[error("is no FBX file that can be read: {reason}; export it again as binary FBX")]
    Fbx {
        /// What the reader says.
        reason: String,
    },
    /// The scene has no polygon mesh.
    #[error("has no polygon mesh; select the skinned mesh, with its joints, for the export")]
    NoMesh,
    /// The scene has no joint.
    #[error(
        "has no joint: no skin names one and no node is a bone; export the skeleton with the mesh, \
         and in Blender its armature too"
    )]
    NoJoint,
    /// The scene has no animation.
    #[error("has no animation; export with animation on, baked to keys at every frame")]
    NoAnimation,
    /// No animation moves a joint.
    #[error(
        "has no key on a joint in {}; bake the animation of the joints to keys at every frame",
        clips.join(", ")
    )]
    StillJoints {
        /// The animations that were looked at.
        clips: Vec<String>,
    },
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
    /// A joint is bound by a matrix without an inverse.
    #[error("mesh {mesh} is bound to joint {joint} by a matrix that is singular; bind it again")]
    SingularBind {
        /// The mesh.
        mesh: String,
        /// The joint.
        joint: String,
    },
    /// Two meshes are bound to a joint in different poses.
    #[error(
        "joint {joint} stands elsewhere where mesh {mesh} is bound than where another mesh is, by \
         {distance}; bind all meshes in one pose, or export one of them"
    )]
    BindsDisagree {
        /// The joint.
        joint: String,
        /// The mesh that comes later.
        mesh: String,
        /// How far apart the places are, in the file's units.
        distance: f64,
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
}
