//! Measures a baked model: the f32 runtime on the file's bytes against the examples, and LBS
//! beside it.

mod character;
mod measured;
mod skin;

pub use character::Character;
pub use measured::{Confidence, Errors, Measured, MeasuredFrame, largest};
pub use skin::{Lbs, Skinned, skin};

use crate::examples::{Examples, ExamplesError, Split};
use crate::posed::FrameError;
use serde::Serialize;
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
    #[error("the model holds a palette alone, without a skin")]
    PaletteAlone,
    /// The model holds no skin of a name.
    #[error("the model holds no skin called {name}; it has: {has}")]
    NoSkin {
        /// The name.
        name: String,
        /// The names that there are.
        has: String,
    },
    /// The model was made for another character.
    #[error("the model has {expected} {what}, the examples have {found}")]
    Mismatch {
        /// Vertices or joints.
        what: &'static str,
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

/// What a model was measured to do.
#[derive(Clone, Debug, Serialize)]
pub struct Evaluation {
    /// Which frames.
    pub split: &'static str,
    /// How many.
    pub frames: usize,
    /// V.
    pub vertices: usize,
    /// Diagonal of the rest pose's bounding box, in units of the input.
    pub diagonal: f64,
    /// The model's errors.
    #[serde(flatten)]
    pub errors: Errors,
    /// What the model thinks of the poses.
    pub confidence: Confidence,
    /// Length of the file.
    pub model_bytes: usize,
    /// What predicts the palette.
    pub predictor: &'static str,
    /// P.
    pub proxies: usize,
    /// 4-influence LBS fitted on the training split, on the same frames.
    pub lbs: Errors,
}

/// Frames to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frames {
    /// Those of one split.
    Of(Split),
    /// All.
    All,
}

impl Frames {
    /// The split's name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Frames::Of(Split::Train) => "train",
            Frames::Of(Split::HeldOut) => "held-out",
            Frames::Of(Split::Extreme) => "extreme",
            Frames::All => "all",
        }
    }

    /// The frames' numbers.
    pub fn of(self, examples: &Examples) -> Vec<usize> {
        match self {
            Frames::Of(split) => examples.frames_of(split),
            Frames::All => (0..examples.frame_len()).collect(),
        }
    }

    /// The frames' numbers, of which there must be one at least, and whose joints must be rigid.
    ///
    /// # Errors
    /// [`EvaluateError::NoFrames`] and [`EvaluateError::Examples`].
    pub fn measurable(self, examples: &Examples) -> Result<Vec<usize>, EvaluateError> {
        let frames = self.of(examples);
        if frames.is_empty() {
            return Err(EvaluateError::NoFrames { split: self.name() });
        }
        examples.check_rigid_in(&frames)?;
        Ok(frames)
    }
}

/// Measures a skin of a model, the first where no name is given, on frames of the examples.
///
/// # Errors
/// Those of [`Character::open`], [`EvaluateError::NoFrames`], [`EvaluateError::Examples`] and
/// [`EvaluateError::Frame`].
pub fn evaluate(
    model: &[u8],
    skin: Option<&str>,
    examples: &Examples,
    frames: Frames,
) -> Result<Evaluation, EvaluateError> {
    let character = Character::open(model, skin, examples)?;
    let chosen = frames.measurable(examples)?;
    let measured = Measured::model(&character, examples, &chosen)?;
    let lbs = Measured::lbs(&Lbs::fit(examples), examples, &chosen);
    Ok(Evaluation::new(frames, (&character, model.len()), &measured, &lbs))
}

impl Evaluation {
    /// Summarises what was measured of a character in a file of so many bytes, and of LBS.
    pub fn new(
        frames: Frames,
        (character, model_bytes): (&Character<'_>, usize),
        measured: &Measured,
        lbs: &Measured,
    ) -> Self {
        let Character { envelope, skin, .. } = character;
        Self {
            split: frames.name(),
            frames: measured.frames.len(),
            vertices: skin.vertex_len(),
            diagonal: measured.diagonal,
            errors: measured.errors(),
            confidence: measured.confidence(),
            model_bytes,
            predictor: envelope.predictor().name(),
            proxies: envelope.proxy_len(),
            lbs: lbs.errors(),
        }
    }
}
