//! The error of a measurement.

use crate::envelope::posed::FrameError;
use crate::examples::{Clip, ExamplesError};
use sinew_runtime::FileError;

/// Reasons why a measurement fails.
#[derive(Debug, thiserror::Error)]
pub enum EvaluateError {
    /// The runtime refuses the model's bytes.
    #[error("the model is refused: {0}")]
    Format(#[from] FileError),
    /// The model holds no envelope, or a skin without an envelope.
    #[error("the model holds no envelope that moves a skin")]
    NoEnvelope,
    /// The model holds envelopes but no skin.
    #[error(
        "the model holds a palette alone, without a skin to measure or to play: train one without --no-skin for that"
    )]
    PaletteAlone,
    /// The model holds no skin of this name.
    #[error("the model holds no skin called {name}; it has: {has}")]
    NoSkin {
        /// The requested name.
        name: String,
        /// The names in the model.
        has: String,
    },
    /// The model's mesh has another number of vertices.
    #[error(
        "the model has {expected} vertices, the examples have {found}: give examples of the file that training had, with its \
         texture's seams where that has them"
    )]
    Vertices {
        /// In the model.
        expected: usize,
        /// In the examples.
        found: usize,
    },
    /// The model's skeleton has another number of joints.
    #[error(
        "the model has {expected} joints, the examples have {found}: give examples of the skeleton that training had"
    )]
    Joints {
        /// In the model.
        expected: usize,
        /// In the examples.
        found: usize,
    },
    /// A joint has another name in the examples.
    #[error("joint {joint} is called {expected} in the model, {found} in the examples")]
    JointName {
        /// Index of the joint.
        joint: usize,
        /// In the model.
        expected: String,
        /// In the examples.
        found: String,
    },
    /// The model's rest mesh differs: another space, or another mesh with the same number of vertices.
    #[error(
        "the model's rest mesh is not that of the examples: off by {percent:.1} % of the diagonal; \
         give the examples as they were given in training, with the same --targets, and say what their \
         file does not by --up, --forward and --unit"
    )]
    RestMesh {
        /// RMS distance in % of the diagonal.
        percent: f64,
    },
    /// The model's rest mesh has the examples' vertices in another order.
    #[error(
        "the model's rest mesh has the vertices of the examples in another order, as FBX and glTF of one character do: give \
         the file that training had, or one that has its order"
    )]
    VertexOrder,
    /// The examples have no such frame.
    #[error("the examples have no {split} frame")]
    NoFrames {
        /// Name of the requested frames.
        split: &'static str,
    },
    /// A frame has a joint that is not rigid.
    #[error(transparent)]
    Examples(#[from] ExamplesError),
    /// The runtime refuses a frame.
    #[error(transparent)]
    Frame(#[from] FrameError),
}

impl EvaluateError {
    /// Replaces the frame index with the source's frame number.
    pub fn called(self, clips: &[Clip]) -> Self {
        match self {
            Self::Examples(error) => Self::Examples(error.called(clips)),
            Self::Frame(error) => Self::Frame(error.called(clips)),
            error => error,
        }
    }
}
