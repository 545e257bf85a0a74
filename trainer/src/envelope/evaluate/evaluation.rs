//! What a model was measured to do, on frames of a split.

use super::character::Character;
use super::error::EvaluateError;
use super::measured::{Confidence, Errors, Measured};
use super::skin::Baseline;
use crate::examples::{Examples, Split};
use serde::Serialize;

/// What a model was measured to do.
#[derive(Clone, Debug, Serialize)]
pub struct Evaluation {
    /// Which frames.
    pub split: &'static str,
    /// How many.
    pub frames: usize,
    /// Vertices of the skin, E.
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
    let lbs = Measured::lbs(&Baseline::fit(examples), examples, &chosen);
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
