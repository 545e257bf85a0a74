//! Errors of an export.

use crate::envelope::levels::LevelError;
use crate::envelope::posed::FrameError;
use crate::evaluate::EvaluateError;
use crate::examples::Clip;
use crate::formats::{FileError, GlbError};
use crate::space::SpaceError;

/// Reasons why an export fails.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The model is refused or does not fit the examples.
    #[error(transparent)]
    Model(#[from] EvaluateError),
    /// There is no clip, or a clip has no frames.
    #[error("there is no frame to export: {clip}")]
    NoFrames {
        /// Message about the clip.
        clip: String,
    },
    /// A clip's times do not ascend from zero in single precision.
    #[error(
        "clip {clip}: frame {frame} plays at {time} s, expected times from 0 on that ascend by more \
         than single precision rounds"
    )]
    Times {
        /// Name of the clip.
        clip: String,
        /// The frame, counted from the clip's first frame.
        frame: usize,
        /// Time of the frame in seconds.
        time: f64,
    },
    /// A further mesh cannot follow the model.
    #[error(transparent)]
    Level(#[from] LevelError),
    /// The runtime refuses a frame.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The requested space is impossible or cannot be reached.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// The requested space is left-handed.
    #[error("glTF is right-handed: leave out --to-hand left, engines mirror it as they import it")]
    LeftHanded,
    /// An artist's file cannot hold the model.
    #[error(transparent)]
    Into(#[from] IntoError),
    /// The file cannot be written.
    #[error(transparent)]
    Glb(#[from] GlbError),
}

impl ExportError {
    /// Replaces the frame index with the source's frame number.
    pub fn called(self, clips: &[Clip]) -> Self {
        match self {
            Self::Model(error) => Self::Model(error.called(clips)),
            Self::Frame(error) => Self::Frame(error.called(clips)),
            error => error,
        }
    }
}

/// Reasons why an artist's file cannot hold a model.
#[derive(Debug, thiserror::Error)]
pub enum IntoError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// No mesh of the file has the model's vertices.
    #[error(
        "no mesh has the model's vertices, within 1e-4 of the diagonal, in any axes and \
         unit: give the character that the model was trained on, in its rest pose"
    )]
    NoMesh,
    /// No node has the name of a joint; other names would match.
    #[error("no node has the name of one of the model's joints: {}; {mismatch}", joints.join(", "))]
    OtherJoints {
        /// Names of the model's joints.
        joints: Vec<String>,
        /// Reason why the names do not match, and the option that fixes them.
        mismatch: String,
    },
    /// A mesh has some of the model's vertices and other vertices.
    #[error(
        "mesh {mesh}: vertex {vertex} at {at:?} is not in the model, {found} of {len} are: train on \
         the mesh as it is, or move the added vertices to a separate mesh"
    )]
    Partly {
        /// Name of the mesh.
        mesh: String,
        /// The first vertex that the model lacks.
        vertex: usize,
        /// Position of the vertex in the file.
        at: [f64; 3],
        /// Number of vertices that the model has.
        found: usize,
        /// Number of vertices of the mesh.
        len: usize,
    },
    /// A joint needs more than a translation, a rotation and an even scale.
    #[error(
        "joint {joint} hangs under nodes that scale unevenly: apply the scale of the armature before \
         exporting"
    )]
    Uneven {
        /// Name of the joint.
        joint: String,
    },
}
