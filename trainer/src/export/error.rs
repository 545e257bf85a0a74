//! Why an export could not be made.

use super::into::error::IntoError;
use crate::envelope::levels::LevelError;
use crate::envelope::posed::FrameError;
use crate::evaluate::EvaluateError;
use crate::examples::Clip;
use crate::formats::GlbError;
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
