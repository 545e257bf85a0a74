//! Why an export could not be made.

use crate::envelope::levels::LevelError;
use crate::envelope::posed::FrameError;
use crate::evaluate::EvaluateError;
use crate::examples::Clip;
use crate::formats::{FileError, GlbError};
use crate::space::SpaceError;

/// An export that could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The model is refused, or does not fit the examples.
    #[error(transparent)]
    Model(#[from] EvaluateError),
    /// There is no clip, or one without frames.
    #[error("there is no frame to export: {clip}")]
    NoFrames {
        /// The clip.
        clip: String,
    },
    /// The times of a clip's frames do not ascend from zero on in single precision.
    #[error(
        "clip {clip}: frame {frame} plays at {time} s, expected times from 0 on that ascend by more \
         than single precision rounds"
    )]
    Times {
        /// The clip.
        clip: String,
        /// The frame, counted from the clip's first.
        frame: usize,
        /// Its time in seconds.
        time: f64,
    },
    /// A further mesh cannot follow the model.
    #[error(transparent)]
    Level(#[from] LevelError),
    /// The runtime refuses a frame.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The space that is asked for cannot be, or not be reached.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// A space that is asked for is not that of the format.
    #[error("glTF is right-handed: leave out --to-hand left, engines mirror it as they import it")]
    LeftHanded,
    /// An artist's file cannot take it.
    #[error(transparent)]
    Into(#[from] IntoError),
    /// The file cannot be put together.
    #[error(transparent)]
    Glb(#[from] GlbError),
}

impl ExportError {
    /// Calls the frame that it points at as its source does, of frames of these clips.
    pub fn called(self, clips: &[Clip]) -> Self {
        match self {
            Self::Model(error) => Self::Model(error.called(clips)),
            Self::Frame(error) => Self::Frame(error.called(clips)),
            error => error,
        }
    }
}

/// A file that a model cannot be put into.
#[derive(Debug, thiserror::Error)]
pub enum IntoError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// None of its vertices is one of the model's.
    #[error(
        "no mesh has its vertices where the model's are, within 1e-4 of the diagonal, in any axes and \
         unit: give the character that the model was trained on, in its rest pose"
    )]
    NoMesh,
    /// None of its nodes has the name of a joint, but would with other names.
    #[error("has none of the model's joints, by name: {}; {mismatch}", joints.join(", "))]
    OtherJoints {
        /// The model's.
        joints: Vec<String>,
        /// What keeps the names from matching, and the option that mends it.
        mismatch: String,
    },
    /// Some vertices of a mesh are the model's, and others are not.
    #[error(
        "mesh {mesh}: vertex {vertex} at {at:?} is none of the model's, {found} of {len} are: train on \
         the mesh as it is, or part what was added to it into a mesh of its own"
    )]
    Partly {
        /// The mesh.
        mesh: String,
        /// Its first vertex that was not found.
        vertex: usize,
        /// Where that is in the file.
        at: [f64; 3],
        /// Vertices that were found.
        found: usize,
        /// Its vertices.
        len: usize,
    },
    /// A joint cannot be placed by a move, a turn and an even scale.
    #[error(
        "joint {joint} hangs under nodes that scale unevenly: apply the scale of the armature before \
         exporting"
    )]
    Uneven {
        /// The joint.
        joint: String,
    },
}
