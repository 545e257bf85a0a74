//! What can be wrong with example poses.

use super::rigidity::Distortion;
use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

use super::import::ImportError;
use crate::formats::scene::{Clip, RATES};
use crate::formats::{FileError, FormatError};
use crate::space::SpaceError;

/// A file of examples that could not be used.
#[derive(Debug, thiserror::Error)]
#[error("{}: {error}", file.display())]
pub struct LoadError {
    /// The file at fault.
    pub file: PathBuf,
    /// What is wrong with it.
    pub error: ExamplesError,
}

impl From<FileError> for LoadError {
    fn from(FileError { file, error }: FileError) -> Self {
        Self { file, error: error.into() }
    }
}

/// A fault in examples, with its place.
#[derive(Debug, thiserror::Error)]
pub enum ExamplesError {
    /// The description beside the arrays is not the JSON expected.
    #[error("is not a description of examples: {reason}")]
    Json {
        /// What the parser says, with line and column.
        reason: String,
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
    #[error("{} is not finite at {}{element}", named(array), in_frame(*frame))]
    NotFinite {
        /// The array.
        array: &'static str,
        /// The frame, for arrays that have one: its place, or what its source calls it.
        frame: Option<i64>,
        /// The vertex or joint.
        element: Element,
    },
    /// A number is larger than a model can hold.
    #[error(
        "{} exceeds {:e}, the most a model can hold, at {}{element}",
        named(array),
        sinew_runtime::format::MAGNITUDE_MAX,
        in_frame(*frame)
    )]
    TooLarge {
        /// The array.
        array: &'static str,
        /// The frame, for arrays that have one: its place, or what its source calls it.
        frame: Option<i64>,
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
    /// A vertex has no copy among the engine's.
    #[error("vertex {vertex} has no copy among the engine's vertices")]
    NoCopy {
        /// The vertex.
        vertex: usize,
    },
    /// A triangle of the engine's is another one than the mesh's.
    #[error(
        "triangle {triangle} has the vertices {expected:?}, by the engine's vertices it has copies of {found:?}"
    )]
    OtherCopy {
        /// The triangle.
        triangle: usize,
        /// Its vertices.
        expected: [usize; 3],
        /// What its engine vertices are copies of.
        found: [usize; 3],
    },
    /// No triangle of the rest mesh has an area.
    #[error("none of the {triangle_len} rest triangles has an area")]
    NoArea {
        /// How many triangles there are.
        triangle_len: usize,
    },
    /// A clip or mesh does not begin behind the one before it.
    #[error(
        "array {array} has {found} for {name}, expected 0 for the first, then ascending numbers below {len}"
    )]
    Start {
        /// The array.
        array: &'static str,
        /// The clip or mesh.
        name: String,
        /// What it begins with.
        found: i64,
        /// How many frames or vertices there are.
        len: usize,
    },
    /// What a frame is called does not ascend in its clip.
    #[error(
        "array frame_numbers has {found} at frame {frame}, expected {least} to {}: numbers ascend in each clip",
        i32::MAX
    )]
    FrameNumber {
        /// The frame, by its place.
        frame: usize,
        /// What it is called.
        found: i64,
        /// The least that it may be called.
        least: i64,
    },
    /// A frame counts some number of times that is not whole, none, or too many.
    #[error(
        "array frame_weights has {number} at frame {frame}, expected a whole number from 1 to {most}; what is not to be \
             read has split 1 or 2"
    )]
    FrameWeight {
        /// The frame, as its source calls it.
        frame: i64,
        /// The number.
        number: f64,
        /// The most that it may be.
        most: f64,
    },
    /// Frames follow at no rate that can be played.
    #[error("array fps has {fps}, expected {} to {} frames a second", RATES.start(), RATES.end())]
    Rate {
        /// Frames a second.
        fps: f64,
    },
    /// A word is none of those that are known.
    #[error("array {array} has {found:?}, expected {expected}")]
    UnknownWord {
        /// The array.
        array: &'static str,
        /// The word.
        found: String,
        /// What it may be.
        expected: &'static str,
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
    #[error("{}, joint {joint} {distortion}", match frame {
        None => "in the rest pose".to_owned(),
        Some(frame) => format!("at frame {frame}"),
    })]
    NonRigidJoint {
        /// The frame, its place or what its source calls it; none of the rest pose.
        frame: Option<i64>,
        /// The joint.
        joint: String,
        /// What its matrix does.
        distortion: Distortion,
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
    #[error("{}", too_few(*found, *needed))]
    TooFewPoses {
        /// Frames there are.
        found: usize,
        /// Frames needed.
        needed: usize,
    },
    /// Every frame is held out, or extreme.
    #[error("every frame of {frame_len} is held out or extreme: none is left to train")]
    NothingTrains {
        /// Frames there are.
        frame_len: usize,
    },
    /// A share of frames to hold out is not between 0 and 1.
    #[error("the share of held-out frames must lie between 0 and 1, found {share}")]
    BadShare {
        /// The share.
        share: f64,
    },
    /// A joint cannot weigh so much.
    #[error(
        "array joint_weights has {number} at vertex {vertex}, joint {joint}, expected a number that is finite and not \
             negative"
    )]
    JointWeight {
        /// The vertex.
        vertex: usize,
        /// The joint.
        joint: String,
        /// What was given.
        number: f64,
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
    /// A file cannot be read or written.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A scene cannot become examples.
    #[error(transparent)]
    Import(#[from] ImportError),
}

impl ExamplesError {
    /// Names the part of a scene, which has no arrays.
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

    /// Calls the frame that it points at as its source does, of frames of these clips.
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

/// Names an array, or the part of a scene that [`ExamplesError::of_scene`] calls it.
fn named(array: &str) -> String {
    if array.contains(' ') { format!("the {array}") } else { format!("array {array}") }
}

/// Says that frames are too few.
fn too_few(found: usize, needed: usize) -> String {
    match found {
        0 => "no frame is left to train: all are held out or extreme".to_owned(),
        _ => format!("{found} frames are too few, {needed} are needed"),
    }
}

/// Gives what the source calls a frame, or its place where the source calls it nothing.
pub(crate) fn called(frame: i64, clips: &[Clip]) -> i64 {
    let within = |clip: &Clip| clip.number(usize::try_from(frame).ok()?.checked_sub(clip.first)?);
    clips.iter().find_map(within).unwrap_or(frame)
}

/// The part of an example that an error points at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Element {
    /// A vertex by number.
    Vertex(usize),
    /// A joint by name.
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

/// Says in which frame, before a place in it.
pub(super) fn in_frame(frame: Option<i64>) -> String {
    frame.map(|frame| format!("frame {frame}, ")).unwrap_or_default()
}
