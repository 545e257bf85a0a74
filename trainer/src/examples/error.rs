//! What can be wrong with example poses, and what is only worth saying.

use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

use super::rig::ImportError;
use super::space::SpaceError;
use super::targets::TargetsError;

/// A file of examples that could not be used.
#[derive(Debug, thiserror::Error)]
#[error("{}: {error}", file.display())]
pub struct LoadError {
    /// The file at fault.
    pub file: PathBuf,
    /// What is wrong with it.
    pub error: ExamplesError,
}

/// A fault in examples, with its place.
#[derive(Debug, thiserror::Error)]
pub enum ExamplesError {
    /// The file cannot be opened or read.
    #[error("cannot be read: {0}")]
    Read(std::io::Error),
    /// The file cannot be written.
    #[error("cannot be written: {0}")]
    Write(std::io::Error),
    /// The archive is truncated or is no npz at all.
    #[error("is not a whole npz archive: {reason}")]
    Archive {
        /// What the archive's reader says.
        reason: String,
    },
    /// An array inside the archive is damaged or is no npy data.
    #[error("array {array} is damaged: {reason}")]
    DamagedArray {
        /// The array.
        array: String,
        /// What the array's reader says.
        reason: String,
    },
    /// The description beside the arrays is not the JSON expected.
    #[error("is not a description of examples: {reason}")]
    Json {
        /// What the parser says, with line and column.
        reason: String,
    },
    /// Something that every set of examples has is absent.
    #[error("array {array} is missing")]
    MissingArray {
        /// The array, or the arrays of which one must be present.
        array: &'static str,
    },
    /// An array holds another kind of number.
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
        /// The shape expected; letters stand for any count.
        expected: String,
        /// The shape found.
        found: Vec<u64>,
    },
    /// Two arrays disagree about a count.
    #[error("{first} has {first_len} {what}, {second} has {second_len}")]
    Mismatch {
        /// What is counted.
        what: &'static str,
        /// One array.
        first: &'static str,
        /// Its count.
        first_len: usize,
        /// The other array.
        second: &'static str,
        /// Its count.
        second_len: usize,
    },
    /// An array that may not be empty is.
    #[error("array {array} is empty")]
    Empty {
        /// The array.
        array: &'static str,
    },
    /// A number is NaN or infinite.
    #[error("array {array} is not finite at {}{element}", in_frame(*frame))]
    NotFinite {
        /// The array.
        array: &'static str,
        /// The frame, for arrays that have one.
        frame: Option<usize>,
        /// The vertex or joint.
        element: Element,
    },
    /// A number is larger than a model can hold.
    #[error(
        "array {array} exceeds {:e}, the most a model can hold, at {}{element}",
        sinew_runtime::format::MAGNITUDE_MAX,
        in_frame(*frame)
    )]
    TooLarge {
        /// The array.
        array: &'static str,
        /// The frame, for arrays that have one.
        frame: Option<usize>,
        /// The vertex or joint.
        element: Element,
    },
    /// A face names a vertex that does not exist.
    #[error("{array} {face} names vertex {vertex} of {vertex_len}")]
    VertexOutOfRange {
        /// The array of faces.
        array: &'static str,
        /// The face.
        face: usize,
        /// The number it holds.
        vertex: i64,
        /// How many vertices there are.
        vertex_len: usize,
    },
    /// No triangle of the rest mesh has an area.
    #[error("none of the {triangle_len} rest triangles has an area")]
    NoArea {
        /// How many triangles there are.
        triangle_len: usize,
    },
    /// A joint's parent does not exist.
    #[error("joint {joint} has parent {parent}, which does not exist")]
    MissingParent {
        /// The joint.
        joint: String,
        /// Its parent as the file has it.
        parent: String,
    },
    /// Following parents from a joint leads back to it.
    #[error("joints are their own ancestors: {}", joints.join(" -> "))]
    JointCycle {
        /// The joints of the cycle, child before parent, the first repeated at the end.
        joints: Vec<String>,
    },
    /// Two joints have one name.
    #[error("joints {first} and {second} are both called {name}")]
    DuplicateJoint {
        /// The name.
        name: String,
        /// One joint.
        first: usize,
        /// The other joint.
        second: usize,
    },
    /// A rest position is given for a joint that does not exist.
    #[error("joint_rest_positions names joint {name}, which does not exist")]
    UnknownJoint {
        /// The name.
        name: String,
    },
    /// A joint's matrix is a reflection, is collapsed, is not affine, or scales or shears too much.
    #[error(
        "array {array} is not rigid at {}joint {joint}: off by {deviation:.3e}, at most {} can be repaired",
        in_frame(*frame), super::validate::REPAIRABLE
    )]
    NonRigidJoint {
        /// The array.
        array: &'static str,
        /// The frame, for arrays that have one.
        frame: Option<usize>,
        /// The joint.
        joint: String,
        /// Largest distance of a signed singular value from 1, or of the last row from 0 0 0 1.
        deviation: f64,
    },
    /// A frame's split is none of the known codes.
    #[error("array split has code {code} at frame {frame}, expected 0, 1 or 2")]
    UnknownSplit {
        /// The frame.
        frame: usize,
        /// The code.
        code: i64,
    },
    /// There are not enough frames for what is asked.
    #[error("{found} frames are too few, {needed} are needed")]
    TooFewPoses {
        /// Frames there are.
        found: usize,
        /// Frames needed.
        needed: usize,
    },
    /// A share of frames to hold out is not between 0 and 1.
    #[error("the share of held-out frames must lie between 0 and 1, found {share}")]
    BadShare {
        /// The share.
        share: f64,
    },
    /// A vertex cannot count so much.
    #[error("the importance of vertex {vertex} must be finite and not negative, found {number}")]
    Importance {
        /// The vertex.
        vertex: usize,
        /// What was given.
        number: f64,
    },
    /// No vertex counts.
    #[error("the importance of every vertex is 0")]
    NothingCounts,
    /// Axes or unit cannot be.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// A named range of vertices lies outside the mesh or not behind the one before it.
    #[error(
        "mesh {name} has the vertices {} to {} (exclusive), expected them from {least} to {vertex_len}",
        range.start,
        range.end
    )]
    Range {
        /// Its name.
        name: String,
        /// Its vertices.
        range: Range<usize>,
        /// Where the one before it ends.
        least: usize,
        /// V.
        vertex_len: usize,
    },
    /// A scene cannot become examples.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// A mesh, or posed meshes, cannot be read.
    #[error(transparent)]
    Targets(#[from] TargetsError),
}

/// The part of an example that an error points at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Element {
    /// A vertex by number.
    Vertex(usize),
    /// A joint by name.
    Joint(String),
}

/// Something that does not stop a fit but that the user should know.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// A joint's maps are not quite rigid; a fit uses the rotation nearest to each.
    NonRigidJoint {
        /// The array.
        array: &'static str,
        /// The joint.
        joint: String,
        /// How many of its matrices are off.
        matrix_len: usize,
        /// The frame of the worst, for arrays that have one.
        worst_frame: Option<usize>,
        /// How far the worst is off.
        deviation: f64,
    },
    /// Triangles that name a vertex twice; they carry no equation.
    RepeatedVertex {
        /// The triangles.
        triangles: Vec<usize>,
    },
    /// Triangles without area in the rest pose; they carry no equation.
    ZeroArea {
        /// The triangles.
        triangles: Vec<usize>,
    },
    /// Texture coordinates are not one per vertex and are ignored, so there are no tangents.
    UvIgnored {
        /// Texture coordinates found.
        uv_len: usize,
        /// Vertices.
        vertex_len: usize,
    },
    /// Several joints have no parent: the first is the reference, the others become its children.
    SeveralRoots {
        /// The roots, the reference first.
        joints: Vec<String>,
    },
    /// Meshes without a skin stand beside meshes that have one, and are left out.
    UnskinnedMeshes {
        /// The meshes.
        meshes: Vec<String>,
    },
    /// Clips that move no joint and no shape of the mesh are left out.
    IdleClips {
        /// The clips.
        clips: Vec<String>,
    },
    /// Meshes that a point cache outside the scene deforms, which is not read with it.
    CacheIgnored {
        /// The meshes.
        meshes: Vec<String>,
    },
    /// The meshes to learn are the scene's own linear blend skinning.
    PlainSkin,
    /// Joints or targets came in other axes or units and were moved.
    Moved {
        /// What was moved.
        what: &'static str,
        /// Where to.
        how: String,
    },
}

/// How many triangles a message lists before it only counts.
const LISTED: usize = 8;

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Element::Vertex(vertex) => write!(f, "vertex {vertex}"),
            Element::Joint(joint) => write!(f, "joint {joint}"),
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::NonRigidJoint { array, joint, matrix_len, worst_frame, deviation } => {
                let place = in_frame(*worst_frame);
                write!(
                    f,
                    "array {array} is not rigid at {place}joint {joint}: off by {deviation:.1e} at \
                     worst, matrices off in all: {matrix_len}"
                )
            }
            Warning::RepeatedVertex { triangles } => {
                write!(
                    f,
                    "triangles that name a vertex twice are left out of the fit: {}",
                    Listed(triangles)
                )
            }
            Warning::ZeroArea { triangles } => {
                write!(
                    f,
                    "triangles without area at rest are left out of the fit: {}",
                    Listed(triangles)
                )
            }
            Warning::UvIgnored { uv_len, vertex_len } => {
                write!(f, "uv is ignored: {uv_len} coordinates for {vertex_len} vertices")
            }
            Warning::SeveralRoots { joints } => {
                let (reference, others) =
                    joints.split_first().map_or(("", &[][..]), |(a, b)| (a, b));
                write!(
                    f,
                    "{} joints have no parent: {reference} is the root, {} now hang under it",
                    joints.len(),
                    others.join(", ")
                )
            }
            Warning::UnskinnedMeshes { meshes } => {
                write!(f, "meshes without a skin are left out: {}", meshes.join(", "))
            }
            Warning::IdleClips { clips } => {
                write!(
                    f,
                    "clips that move neither a joint nor a shape of the mesh are left out: {}",
                    clips.join(", ")
                )
            }
            Warning::CacheIgnored { meshes } => {
                write!(
                    f,
                    "point caches of meshes are not read with the scene: {}; give them as --targets",
                    meshes.join(", ")
                )
            }
            Warning::PlainSkin => f.write_str(
                "no shapes move and no targets are given: the meshes are the scene's own linear \
                 blend skinning, of which there is nothing to learn; give the posed meshes as \
                 --targets",
            ),
            Warning::Moved { what, how } => {
                write!(f, "the {what} came in other axes or units and were moved: {how}")
            }
        }
    }
}

struct Listed<'a>(&'a [usize]);

impl fmt::Display for Listed<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, number) in self.0.iter().take(LISTED).enumerate() {
            write!(f, "{}{number}", if place == 0 { "" } else { ", " })?;
        }
        if self.0.len() > LISTED { f.write_str(", ...") } else { Ok(()) }
    }
}

fn in_frame(frame: Option<usize>) -> String {
    frame.map(|frame| format!("frame {frame}, ")).unwrap_or_default()
}
