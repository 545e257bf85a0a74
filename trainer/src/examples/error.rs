//! Errors in example poses.

use super::distortion::Distortion;
use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

use super::import::ImportError;
use crate::formats::scene::{Clip, RATES};
use crate::formats::{FileError, FormatError};
use crate::space::SpaceError;

/// An unusable file of examples.
#[derive(Debug, thiserror::Error)]
#[error("{}: {error}", file.display())]
pub struct LoadError {
    /// The file.
    pub file: PathBuf,
    /// The error in the file.
    pub error: ExamplesError,
}

impl From<FileError> for LoadError {
    fn from(FileError { file, error }: FileError) -> Self {
        Self { file, error: error.into() }
    }
}

/// An error in examples, with its location.
#[derive(Debug, thiserror::Error)]
pub enum ExamplesError {
    /// The JSON beside the arrays does not have the expected fields.
    #[error("is not a description of examples: {reason}")]
    Json {
        /// Message of the parser, with line and column.
        reason: String,
    },
    /// Two arrays have different lengths.
    #[error("{first} has {first_len} {what}, {second} has {second_len}")]
    Mismatch {
        /// The counted items.
        what: &'static str,
        /// Name of an array.
        first: &'static str,
        /// Items in the first array.
        first_len: usize,
        /// Name of the other array.
        second: &'static str,
        /// Items in the second array.
        second_len: usize,
    },
    /// A required array is empty.
    #[error("array {array} is empty")]
    Empty {
        /// Name of the array.
        array: &'static str,
    },
    /// A number is NaN or infinite.
    #[error("{} is not finite at {}{element}", named(array), in_frame(*frame))]
    NotFinite {
        /// Name of the array.
        array: &'static str,
        /// Frame index or source frame number, for arrays over frames.
        frame: Option<i64>,
        /// The vertex or joint.
        element: Element,
    },
    /// A number exceeds the range of a model.
    #[error(
        "{} exceeds {:e}, the most a model can hold, at {}{element}",
        named(array),
        sinew_runtime::format::MAGNITUDE_MAX,
        in_frame(*frame)
    )]
    TooLarge {
        /// Name of the array.
        array: &'static str,
        /// Frame index or source frame number, for arrays over frames.
        frame: Option<i64>,
        /// The vertex or joint.
        element: Element,
    },
    /// A face has a vertex number out of range.
    #[error("{array} {face} names vertex {vertex} of {vertex_len}")]
    VertexOutOfRange {
        /// Name of the array of faces.
        array: &'static str,
        /// Number of the face.
        face: usize,
        /// The vertex number.
        vertex: i64,
        /// Number of vertices.
        vertex_len: usize,
    },
    /// A vertex has no copy among the engine vertices.
    #[error("vertex {vertex} has no copy among the engine's vertices")]
    NoCopy {
        /// The vertex.
        vertex: usize,
    },
    /// An engine triangle differs from the mesh's triangle.
    #[error(
        "triangle {triangle} has the vertices {expected:?}, but its engine vertices are copies of {found:?}"
    )]
    OtherCopy {
        /// Number of the triangle.
        triangle: usize,
        /// Vertices of the mesh's triangle.
        expected: [usize; 3],
        /// Vertices behind the engine triangle's corners.
        found: [usize; 3],
    },
    /// Every triangle of the rest mesh has zero area.
    #[error("none of the {triangle_len} rest triangles has an area")]
    NoArea {
        /// Number of triangles.
        triangle_len: usize,
    },
    /// A clip or mesh does not start after the previous one.
    #[error(
        "array {array} has {found} for {name}, expected 0 for the first, then ascending numbers below {len}"
    )]
    Start {
        /// Name of the array.
        array: &'static str,
        /// Name of the clip or mesh.
        name: String,
        /// The start.
        found: i64,
        /// Number of frames or vertices.
        len: usize,
    },
    /// Source frame numbers do not ascend within a clip.
    #[error(
        "array frame_numbers has {found} at frame {frame}, expected {least} to {}: numbers ascend in each clip",
        i32::MAX
    )]
    FrameNumber {
        /// Frame index.
        frame: usize,
        /// The source frame number.
        found: i64,
        /// Least allowed number.
        least: i64,
    },
    /// A frame's weight is not a whole number in the allowed range.
    #[error(
        "array frame_weights has {number} at frame {frame}, expected a whole number from 1 to {most}; to leave a \
             frame out, give it split 1 or 2"
    )]
    FrameWeight {
        /// Source frame number.
        frame: i64,
        /// The weight.
        number: f64,
        /// Largest allowed weight.
        most: f64,
    },
    /// The frame rate is out of range.
    #[error("array fps has {fps}, expected {} to {} frames a second", RATES.start(), RATES.end())]
    Rate {
        /// Frames a second.
        fps: f64,
    },
    /// A word is not one of the known words.
    #[error("array {array} has {found:?}, expected {expected}")]
    UnknownWord {
        /// Name of the array.
        array: &'static str,
        /// The word.
        found: String,
        /// The known words.
        expected: &'static str,
    },
    /// A joint's parent does not exist.
    #[error("joint {joint} has parent {parent}, which does not exist")]
    MissingParent {
        /// Name of the joint.
        joint: String,
        /// The parent as written in the file.
        parent: String,
    },
    /// The joints' parents form a cycle.
    #[error("joints are their own ancestors: {}", joints.join(" -> "))]
    JointCycle {
        /// Names along the cycle, each child before its parent; the first name is repeated at the end.
        joints: Vec<String>,
    },
    /// Two joints have the same name.
    #[error("joints {first} and {second} are both called {name}")]
    DuplicateJoint {
        /// The name.
        name: String,
        /// Number of the first joint.
        first: usize,
        /// Number of the second joint.
        second: usize,
    },
    /// A rest position is given for a joint that does not exist.
    #[error("joint_rest_positions names joint {name}, which does not exist")]
    UnknownJoint {
        /// The name.
        name: String,
    },
    /// A joint's matrix is a reflection, singular, not affine, or scales or shears too much.
    #[error("{}, joint {joint} {distortion}", match frame {
        None => "in the rest pose".to_owned(),
        Some(frame) => format!("at frame {frame}"),
    })]
    NonRigidJoint {
        /// Frame index or source frame number; `None` for the rest pose.
        frame: Option<i64>,
        /// Name of the joint.
        joint: String,
        /// Kind of distortion.
        distortion: Distortion,
    },
    /// A code in the split is unknown.
    #[error("array split has code {code} at frame {frame}, expected 0, 1 or 2")]
    UnknownSplit {
        /// Frame index.
        frame: usize,
        /// The code.
        code: i64,
    },
    /// There are too few frames.
    #[error("{}", too_few(*found, *needed))]
    TooFewPoses {
        /// Number of frames.
        found: usize,
        /// Required number of frames.
        needed: usize,
    },
    /// No frame trains.
    #[error("every frame of {frame_len} is held out or extreme: none is left to train")]
    NothingTrains {
        /// Number of frames.
        frame_len: usize,
    },
    /// The share of held-out frames is not between 0 and 1.
    #[error("the share of held-out frames must lie between 0 and 1, found {share}")]
    BadShare {
        /// The share.
        share: f64,
    },
    /// A joint weight is negative or not finite.
    #[error(
        "array joint_weights has {number} at vertex {vertex}, joint {joint}, expected a number that is finite and not \
             negative"
    )]
    JointWeight {
        /// The vertex.
        vertex: usize,
        /// Name of the joint.
        joint: String,
        /// The weight.
        number: f64,
    },
    /// A vertex's importance is negative or not finite.
    #[error("the importance of vertex {vertex} must be finite and not negative, found {number}")]
    Importance {
        /// The vertex.
        vertex: usize,
        /// The importance.
        number: f64,
    },
    /// Every vertex has importance 0.
    #[error("the importance of every vertex is 0")]
    NothingCounts,
    /// The axes or the unit are invalid.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// A named range of vertices is outside the mesh or overlaps the previous range.
    #[error(
        "mesh {name} has the vertices {} to {} (exclusive), expected them from {least} to {vertex_len}",
        range.start,
        range.end
    )]
    Range {
        /// Name of the mesh.
        name: String,
        /// Range of its vertices.
        range: Range<usize>,
        /// End of the previous range.
        least: usize,
        /// Number of vertices, V.
        vertex_len: usize,
    },
    /// A file cannot be read or written.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A scene cannot be converted to examples.
    #[error(transparent)]
    Import(#[from] ImportError),
}

impl ExamplesError {
    /// Replaces array names by parts of a scene, since a scene has no arrays.
    pub(crate) fn of_scene(mut self) -> Self {
        if let Self::NotFinite { array, .. } | Self::TooLarge { array, .. } = &mut self {
            *array = match *array {
                "rest" => "rest mesh",
                "vertices" => "posed mesh",
                "joint_world_rest" => "rest pose",
                "bone_transforms" => "animated pose",
                "uv" => "texture coordinate of the mesh",
                "normals" => "normal of the mesh",
                "tangents" => "tangent of the mesh",
                other => other,
            };
        }
        self
    }

    /// Replaces the frame index by the source's frame number.
    pub(crate) fn called(mut self, clips: &[Clip]) -> Self {
        if let Self::NotFinite { frame: Some(frame), .. }
        | Self::TooLarge { frame: Some(frame), .. }
        | Self::NonRigidJoint { frame: Some(frame), .. }
        | Self::FrameWeight { frame, .. } = &mut self
        {
            *frame = called(*frame, clips);
        }
        self
    }
}

/// Formats the name of an array, or of a part of a scene after [`ExamplesError::of_scene`].
fn named(array: &str) -> String {
    if array.contains(' ') { format!("the {array}") } else { format!("array {array}") }
}

/// Formats the message about too few frames.
fn too_few(found: usize, needed: usize) -> String {
    match found {
        0 => "no frame is left to train: all are held out or extreme".to_owned(),
        _ => format!("{found} frames are too few, {needed} are needed"),
    }
}

/// Returns the source's number of a frame; the frame index if the source has no number.
pub(crate) fn called(frame: i64, clips: &[Clip]) -> i64 {
    let within = |clip: &Clip| clip.number(usize::try_from(frame).ok()?.checked_sub(clip.first)?);
    clips.iter().find_map(within).unwrap_or(frame)
}

/// Location of an error within a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Element {
    /// A vertex, by number.
    Vertex(usize),
    /// A joint, by name.
    Joint(String),
}

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Element::Vertex(vertex) => write!(f, "vertex {vertex}"),
            Element::Joint(joint) => write!(f, "joint {joint}"),
        }
    }
}

/// Formats the frame as a prefix of a location.
pub(super) fn in_frame(frame: Option<i64>) -> String {
    frame.map(|frame| format!("frame {frame}, ")).unwrap_or_default()
}
