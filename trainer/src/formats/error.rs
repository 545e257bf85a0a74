//! Errors of files of every format, and warnings about data that a reader leaves out.

use std::fmt;
use std::path::PathBuf;

/// A file that cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {error}", file.display())]
pub struct FileError {
    /// The faulty file.
    pub file: PathBuf,
    /// The fault.
    pub error: FormatError,
}

/// Faults of a file.
#[derive(Debug, thiserror::Error)]
pub enum FormatError {
    /// The file cannot be opened or read.
    #[error("cannot be read: {0}")]
    Read(std::io::Error),
    /// The file cannot be written.
    #[error("cannot be written: {0}")]
    Write(std::io::Error),
    /// No reader exists for the file's ending.
    #[error("expected a file that ends in {expected}, found {found}")]
    UnknownFormat {
        /// The supported endings.
        expected: &'static str,
        /// The ending of the file.
        found: String,
    },
    /// The format is known but not supported.
    #[error("is {format}, which is not read: {remedy}")]
    Unread {
        /// The format.
        format: &'static str,
        /// The way to a supported format.
        remedy: &'static str,
    },
    /// The file is empty.
    #[error("is empty")]
    Empty,
    /// The file is a baked model instead of examples.
    #[error("is a baked model, expected examples: commands take the model first")]
    Model,
    /// The content belongs to another ending.
    #[error("holds what a .{ending} file holds: give it that ending")]
    OtherContent {
        /// The ending that fits the content.
        ending: &'static str,
    },
    /// A scene is damaged, or lacks a part of a rigged character.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Arrays are missing, damaged or of another kind than expected.
    #[error(transparent)]
    Array(#[from] ArrayError),
    /// A point cache is damaged, or the file is no point cache.
    #[error(transparent)]
    PointCache(#[from] PointCacheError),
    /// An Alembic archive is damaged, or its meshes change over time.
    #[error(transparent)]
    Alembic(#[from] AlembicError),
    /// Meshes do not form a sequence.
    #[error(transparent)]
    Sequence(#[from] SequenceError),
    /// The file is not OBJ, or a folder of OBJ files is not a face.
    #[error(transparent)]
    Obj(#[from] ObjError),
    /// The file is not a layered picture, or lacks a layer.
    #[error(transparent)]
    Layered(#[from] LayeredError),
    /// The file is not a table of numbers.
    #[error(transparent)]
    Csv(#[from] CsvError),
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

/// Reasons why an array, or an archive of arrays, cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ArrayError {
    /// The archive is truncated, or the file is not npz.
    #[error(
        "is no whole .npz archive: its {found} bytes do not end with the archive's directory; write it, or copy it, again"
    )]
    Archive {
        /// Size of the file, in bytes.
        found: u64,
    },
    /// An array is damaged, or is not npy data.
    #[error("array {array} is damaged: {reason}; write the file, or copy it, again")]
    Damaged {
        /// The array.
        array: String,
        /// The fault.
        reason: String,
    },
    /// A word of a text is not a number.
    #[error("array {array} has {word:?} as number {place}, expected a number")]
    NoNumber {
        /// The array.
        array: String,
        /// Index of the word, from 0.
        place: usize,
        /// The word.
        word: String,
    },
    /// A required array is missing.
    #[error("array {array} is missing")]
    Missing {
        /// Name of the array; several names if any of them suffices.
        array: &'static str,
    },
    /// An array has another kind of numbers.
    #[error("array {array} must hold {expected}, found dtype {found}")]
    WrongType {
        /// The array.
        array: String,
        /// The kind of number expected.
        expected: &'static str,
        /// The dtype found.
        found: String,
    },
    /// An array has another shape.
    #[error("array {array} must have shape {expected}, found {found:?}")]
    WrongShape {
        /// The array.
        array: String,
        /// The expected shape; a letter means any count.
        expected: String,
        /// The shape found.
        found: Vec<u64>,
    },
}

/// Reasons why a point cache cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum PointCacheError {
    /// The file does not begin as a point cache.
    #[error("is no PointCache2 file of version 1: {reason}; export it as .pc2 again")]
    NotPointCache {
        /// The difference.
        reason: String,
    },
    /// A count in the header is not positive.
    #[error("counts {found} {what}, expected 1 at least; export the point cache again")]
    Count {
        /// `points` or `frames`.
        what: &'static str,
        /// The count.
        found: i32,
    },
    /// The counts in the header ask for more bytes than a file can have.
    #[error(
        "counts {points} points in {frames} frames, more than a file can hold; export the point cache again"
    )]
    TooMany {
        /// Points in a frame.
        points: u64,
        /// Number of frames.
        frames: u64,
    },
    /// The file is too short or too long for its header.
    #[error(
        "should have {expected} bytes by its header, found {found}; export the point cache again"
    )]
    Length {
        /// Bytes that the header asks for.
        expected: u64,
        /// Bytes of the file.
        found: u64,
    },
}

/// Reasons why an Alembic archive cannot be read as posed meshes.
#[derive(Debug, thiserror::Error)]
pub enum AlembicError {
    /// The archive uses the HDF5 container, which is not supported.
    #[error(
        "is Alembic in an HDF5 container, which is not read; export it again with Ogawa as its data format"
    )]
    Hdf5,
    /// The file does not begin as a supported archive.
    #[error("is no Alembic archive of Ogawa's version 1: {reason}; export it as .abc again")]
    NotAlembic {
        /// The difference.
        reason: String,
    },
    /// The program that wrote the file did not finish it.
    #[error("is incomplete: the program that wrote it did not finish; export it again")]
    Unfinished,
    /// The file contradicts itself.
    #[error("is damaged: {what}; export it again")]
    Damaged {
        /// The contradiction.
        what: String,
    },
    /// The file refers to the same bytes so often that reading it would take too much memory.
    #[error(
        "unfolds to more than {most} bytes, the most for a file of its size, by naming the same bytes again and \
         again; export the frames that are wanted alone"
    )]
    TooLarge {
        /// Most bytes allowed.
        most: usize,
    },
    /// The archive has no mesh.
    #[error("holds no polygon mesh: export the character's mesh, as polygons")]
    NoMesh,
    /// A mesh has no positions.
    #[error("mesh {mesh} has no vertex; leave it out, or export it with its points")]
    NoVertices {
        /// The mesh.
        mesh: String,
    },
    /// The number of vertices of a mesh changes over time.
    #[error(
        "mesh {mesh} has {found} vertices in frame {frame}, expected {expected} as in the first; export it \
         without modifiers that change its vertices over time"
    )]
    OtherVertices {
        /// The mesh.
        mesh: String,
        /// First frame with another number.
        frame: usize,
        /// Vertices in that frame.
        found: usize,
        /// Vertices in the first frame.
        expected: usize,
    },
    /// The faces of a mesh change over time.
    #[error(
        "mesh {mesh} has other faces in frame {frame} than in the first; export it without modifiers that \
         change its faces over time"
    )]
    OtherFaces {
        /// The mesh.
        mesh: String,
        /// First frame with other faces.
        frame: usize,
    },
    /// The numbers of samples differ.
    #[error(
        "{object} has {found} samples, expected 1 or {expected} as others have; export all over the same frames \
         and at one rate"
    )]
    OtherSamples {
        /// The mesh or transform.
        object: String,
        /// Its number of samples.
        found: usize,
        /// Largest number of samples in the archive.
        expected: usize,
    },
}

/// Reasons why OBJ files do not form a sequence.
#[derive(Debug, thiserror::Error)]
pub enum SequenceError {
    /// The folder has no OBJ file.
    #[error(
        "is a folder without an .obj file; export one a frame, numbered: pose_1.obj, pose_2.obj"
    )]
    NoObj,
    /// The name of an OBJ file has no frame number.
    #[error("has no frame number before .obj; export one file a frame: pose_1.obj, pose_2.obj")]
    NoNumber,
    /// Two OBJ files have the same number, so that their order is not known.
    #[error(
        "has the frame number of {other}, {number}; keep one of them, or one sequence a folder"
    )]
    SameNumber {
        /// The number.
        number: u64,
        /// Name of the other file.
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
        /// Name of the first file.
        first: String,
    },
    /// The meshes of a sequence have different faces.
    #[error(
        "has other faces than {first}, from face {face} on ({found_len} in all, expected \
         {expected_len}); export every frame with the same faces, not triangulated anew"
    )]
    OtherFaces {
        /// Name of the first file.
        first: String,
        /// First face that differs, counted from 1.
        face: usize,
        /// Faces in the file.
        found_len: usize,
        /// Faces in the first file.
        expected_len: usize,
    },
}

/// Reasons why an OBJ file, or a folder of them, cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ObjError {
    /// The file is not text.
    #[error("is no text, as an OBJ file is")]
    Binary,
    /// A line cannot be read.
    #[error("line {line} is no vertex, texture coordinate, normal or face of numbers: {text}")]
    Line {
        /// Line number, from 1.
        line: usize,
        /// Beginning of the line.
        text: String,
    },
    /// A face refers to a missing item.
    #[error("face {face} refers to a missing {what}; the file has {len}")]
    Corner {
        /// Face number, from 1.
        face: usize,
        /// Kind of the item.
        what: &'static str,
        /// Number of items of that kind.
        len: usize,
    },
    /// No face has three corners.
    #[error("has no face of three corners or more; export a polygon mesh")]
    NoFaces,
    /// A folder has no neutral mesh.
    #[error("has no neutral.obj: save the face at rest under that name, and each shape beside it")]
    NoNeutral,
    /// A folder has no mesh but the neutral one.
    #[error("has no shape beside neutral.obj: save each as an OBJ of its own")]
    NoShapes,
    /// A shape has another number of vertices than the neutral mesh.
    #[error("expected {expected} vertices, as neutral.obj has, found {found}")]
    Vertices {
        /// Vertices of the neutral mesh.
        expected: usize,
        /// Vertices of the shape.
        found: usize,
    },
}

/// Reasons why a layered picture cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum LayeredError {
    /// The file is not a zip archive.
    #[error("expected an OpenRaster file, which is a zip archive: {0}")]
    Archive(String),
    /// The archive lacks a file.
    #[error("has no {0}: expected an OpenRaster file")]
    Missing(String),
    /// The list of layers cannot be read.
    #[error("stack.xml: {0}")]
    Stack(String),
    /// The file is not a Photoshop file.
    #[error("expected a Photoshop file, which begins with 8BPS")]
    NoPsd,
    /// The bytes contradict each other.
    #[error("is damaged: {0}")]
    Damaged(String),
    /// A feature of the file is not supported.
    #[error("has {found}, expected {expected}: convert it and save it again")]
    Unread {
        /// The unsupported feature.
        found: String,
        /// The supported features.
        expected: &'static str,
    },
    /// The picture, or a part of it, is too large.
    #[error("is too large: {0}")]
    TooLarge(String),
    /// The file has no layers.
    #[error("has no layers: save it with layers, or save a PNG")]
    Empty,
    /// Two layers have the same path.
    #[error("has two layers \"{0}\": give each its own name")]
    Twice(String),
    /// No layer has the requested name.
    #[error("has no layer \"{name}\": its layers are {found}")]
    NoLayer {
        /// The requested name.
        name: String,
        /// Paths of the layers.
        found: String,
    },
    /// Several layers have the requested name.
    #[error("has several layers \"{name}\": write one of {found}")]
    Several {
        /// The name.
        name: String,
        /// Paths of these layers.
        found: String,
    },
    /// The requested name belongs to a group.
    #[error("\"{0}\" is a group: merge it, or name its layers")]
    Group(String),
    /// A layer is clipped to a group, to several layers, or to nothing.
    #[error("layer \"{layer}\" is clipped to {base}, expected one layer below it in its group")]
    Clip {
        /// The layer.
        layer: String,
        /// What lies below the layer, in words.
        base: String,
    },
    /// A layer has an unsupported blend mode.
    #[error("layer \"{layer}\" has the blend mode {mode}, expected normal: merge it down")]
    Blend {
        /// The layer.
        layer: String,
        /// Blend mode, as the file writes it.
        mode: String,
    },
    /// The picture of a layer cannot be read.
    #[error("layer \"{layer}\": {what}")]
    Picture {
        /// The layer.
        layer: String,
        /// The fault.
        what: String,
    },
}

/// Reasons why a table cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum CsvError {
    /// The text is not UTF-8, or cannot be parsed.
    #[error("line {line}: {reason}")]
    Text {
        /// Line number, from 1.
        line: u64,
        /// Message of the reader.
        reason: String,
    },
    /// The first line consists of numbers instead of names.
    #[error(
        "line {line}: expected the names of the columns, found numbers ({found}): write a line of names above \
         them"
    )]
    NoNames {
        /// Line number, from 1.
        line: u64,
        /// The numbers found.
        found: String,
    },
    /// Two columns have one name.
    #[error("line 1: two columns are named {name:?}")]
    Twice {
        /// The repeated name.
        name: String,
    },
    /// A line precedes the line of names.
    #[error(
        "line 1: expected the names of {expected} columns, as the next line has, found {found:?}: \
         remove the lines before the names"
    )]
    Title {
        /// Number of columns of the next line.
        expected: usize,
        /// Text of the first line.
        found: String,
    },
    /// A required column is missing.
    #[error("line 1: there is no column {name:?}; there are {found}")]
    Missing {
        /// Name of the column.
        name: String,
        /// Names of the columns found.
        found: String,
    },
    /// A row is shorter or longer than the line of names.
    #[error("line {line}: expected {expected} columns, found {found}")]
    Row {
        /// Line number, from 1.
        line: u64,
        /// Number of named columns.
        expected: usize,
        /// Number of columns of the line.
        found: usize,
    },
    /// A cell is not a number.
    #[error("line {line}, column {column:?}: expected a number, found {found:?}")]
    Number {
        /// Line number, from 1.
        line: u64,
        /// Name of the column.
        column: String,
        /// Text of the cell.
        found: String,
    },
    /// The table has no row.
    #[error("has no row below its line of names")]
    Empty,
}

/// Data of a file that the reader changes or leaves out, and that the user should know about.
#[derive(Clone, Debug, PartialEq)]
pub enum FormatWarning {
    /// Authored normals had no direction; computed normals replace them.
    NormalsRepaired {
        /// Number of corners or vertices.
        count: usize,
    },
    /// Meshes without a skin are left out, because other meshes have a skin.
    UnskinnedMeshes {
        /// The meshes.
        meshes: Vec<String>,
    },
    /// Meshes without shapes are left out, because other meshes have shapes.
    UnshapedMeshes {
        /// The meshes.
        meshes: Vec<String>,
    },
    /// Channels have in-between shapes; only the last shape of each is read.
    ShapesBetween {
        /// The channels.
        channels: Vec<String>,
    },
    /// Clips that move no joint and no shape of the mesh are left out.
    IdleClips {
        /// The clips.
        clips: Vec<String>,
    },
    /// Animation channels that name no node are left out.
    UntargetedChannels {
        /// The clips with untargeted channels.
        clips: Vec<String>,
    },
    /// Points and lines of meshes are left out.
    PointsAndLines {
        /// The meshes.
        meshes: Vec<String>,
    },
    /// Joints had equal names and were renamed.
    EqualNames {
        /// The new names.
        joints: Vec<String>,
    },
    /// Some vertices have no joint weights.
    Unweighted {
        /// Number of vertices.
        count: usize,
        /// What these vertices follow, in words.
        follow: &'static str,
    },
    /// A joint that Blender's exporter adds for vertices without joint weights.
    NeutralBone {
        /// The joint.
        joint: String,
        /// Number of vertices that follow the joint.
        count: usize,
    },
    /// Point caches outside the scene deform some meshes; they are not read with the scene.
    CacheIgnored {
        /// The meshes.
        meshes: Vec<String>,
    },
}

impl fmt::Display for FormatWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FormatWarning::NormalsRepaired { count } => {
                write!(
                    f,
                    "normals that are absent, zero or not finite become those of the faces around \
                     them: {count}"
                )
            }
            FormatWarning::UnskinnedMeshes { meshes } => {
                write!(f, "meshes without a skin are left out: {}", meshes.join(", "))
            }
            FormatWarning::UnshapedMeshes { meshes } => {
                write!(f, "meshes without shapes are left out: {}", meshes.join(", "))
            }
            FormatWarning::ShapesBetween { channels } => {
                write!(
                    f,
                    "in-between shapes are left out, the last shape of each channel is kept: {}",
                    channels.join(", ")
                )
            }
            FormatWarning::IdleClips { clips } => {
                write!(
                    f,
                    "clips that move neither a joint nor a shape of the mesh are left out: {}",
                    clips.join(", ")
                )
            }
            FormatWarning::UntargetedChannels { clips } => {
                write!(
                    f,
                    "animation channels without a node are left out, of the clips: {}",
                    clips.join(", ")
                )
            }
            FormatWarning::PointsAndLines { meshes } => {
                write!(f, "points and lines are left out, of the meshes: {}", meshes.join(", "))
            }
            FormatWarning::EqualNames { joints } => {
                write!(f, "joints with equal names were renamed: {}", joints.join(", "))
            }
            FormatWarning::Unweighted { count, follow } => {
                write!(f, "vertices without a joint's weight, which follow {follow}: {count}")
            }
            FormatWarning::NeutralBone { joint, count } => {
                write!(
                    f,
                    "joint {joint} is not part of the rig: Blender adds it for vertices without a joint's weight, which \
                     stay where they are: {count}; give them weights where the character should take them along"
                )
            }
            FormatWarning::CacheIgnored { meshes } => {
                write!(
                    f,
                    "point caches of meshes are not read with the scene: {}; give them as --targets",
                    meshes.join(", ")
                )
            }
        }
    }
}
