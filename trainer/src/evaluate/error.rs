//! Why a measurement could not be made.

use crate::envelope::posed::FrameError;
use crate::examples::{Clip, ExamplesError};
use sinew_runtime::FileError;

/// A measurement that could not be made.
#[derive(Debug, thiserror::Error)]
pub enum EvaluateError {
    /// The model's bytes are refused.
    #[error("the model is refused: {0}")]
    Format(#[from] FileError),
    /// The model holds no envelope, or a skin that follows none.
    #[error("the model holds no envelope that moves a skin")]
    NoEnvelope,
    /// The model holds envelopes alone.
    #[error(
        "the model holds a palette alone, without a skin to measure or to play: train one without --no-skin for that"
    )]
    PaletteAlone,
    /// The model holds no skin of a name.
    #[error("the model holds no skin called {name}; it has: {has}")]
    NoSkin {
        /// The name.
        name: String,
        /// The names that there are.
        has: String,
    },
    /// The model was made for a mesh of another number of vertices.
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
    /// The model was made for a skeleton of another number of joints.
    #[error(
        "the model has {expected} joints, the examples have {found}: give examples of the skeleton that training had"
    )]
    Joints {
        /// In the model.
        expected: usize,
        /// In the examples.
        found: usize,
    },
    /// A joint of the model has another name in the examples.
    #[error("joint {joint} is called {expected} in the model, {found} in the examples")]
    JointName {
        /// The joint.
        joint: usize,
        /// In the model.
        expected: String,
        /// In the examples.
        found: String,
    },
    /// The model was made in another space, or for another mesh of as many vertices.
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
    /// There is no frame to measure.
    #[error("the examples have no {split} frame")]
    NoFrames {
        /// Which were asked for.
        split: &'static str,
    },
    /// A frame has a joint that is not rigid.
    #[error(transparent)]
    Examples(#[from] ExamplesError),
    /// A frame was refused.
    #[error(transparent)]
    Frame(#[from] FrameError),
}

impl EvaluateError {
    /// Calls the frame that it points at as its source does, of frames of these clips.
    pub fn called(self, clips: &[Clip]) -> Self {
        match self {
            Self::Examples(error) => Self::Examples(error.called(clips)),
            Self::Frame(error) => Self::Frame(error.called(clips)),
            error => error,
        }
    }
}
