//! Measures a baked model: the f32 runtime on the file's bytes against the examples, and LBS
//! beside it.

mod measured;
mod skin;

pub use measured::{Confidence, Errors, Measured, MeasuredFrame, largest};
pub use skin::{Lbs, Skin, palette, skin, skin_on};

use crate::examples::{Examples, ExamplesError, Split};
use serde::Serialize;
use sinew_runtime::{Envelope, EvalError, FormatError, Model};

/// A measurement that could not be made.
#[derive(Debug, thiserror::Error)]
pub enum EvaluateError {
    /// The model's bytes are refused.
    #[error("the model is refused: {0}")]
    Format(#[from] FormatError),
    /// The model holds no envelope.
    #[error("the model holds no envelope")]
    NoEnvelope,
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
         give the examples as they were given in training, with the same --targets"
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
    #[error("frame {frame}: {error}")]
    Frame {
        /// The frame.
        frame: usize,
        /// Why.
        error: EvalError,
    },
}

/// Two rest meshes stand in one space within this share of the diagonal, RMS: other axes and units
/// are further apart, a sculpt that was changed since shows as an error like any other.
const SAME_SPACE: f64 = 0.05;

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

/// Reads a model's envelope.
///
/// # Errors
/// [`EvaluateError::Format`] and [`EvaluateError::NoEnvelope`].
pub fn envelope(model: &[u8]) -> Result<Envelope<'_>, EvaluateError> {
    Model::from_bytes(model)?.envelope().ok_or(EvaluateError::NoEnvelope)
}

/// Lists the rest positions of an envelope's V vertices.
pub fn rest(envelope: &Envelope<'_>) -> Vec<[f64; 3]> {
    let position = |vertex| envelope.rest_position(vertex).unwrap_or_default().map(f64::from);
    (0..envelope.vertex_len()).map(position).collect()
}

/// Opens a model's envelope and checks that it was made for the examples' character.
///
/// # Errors
/// Those of [`envelope`], [`EvaluateError::Mismatch`], [`EvaluateError::JointName`] and
/// [`EvaluateError::RestMesh`].
pub fn open<'a>(model: &'a [u8], examples: &Examples) -> Result<Envelope<'a>, EvaluateError> {
    let envelope = envelope(model)?;
    for (what, expected, found) in [
        ("vertices", envelope.vertex_len(), examples.vertex_len()),
        ("joints", envelope.joint_len(), examples.joint_len()),
    ] {
        if expected != found {
            return Err(EvaluateError::Mismatch { what, expected, found });
        }
    }
    for (joint, found) in examples.skeleton.names.iter().enumerate() {
        let expected = envelope.joint_name(joint).unwrap_or_default();
        if expected != found {
            let (expected, found) = (expected.to_owned(), found.clone());
            return Err(EvaluateError::JointName { joint, expected, found });
        }
    }
    let squares = rest(&envelope).into_iter().zip(&examples.rest);
    let squares = squares.map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>());
    let apart = (squares.sum::<f64>() / examples.vertex_len().max(1) as f64).sqrt();
    if apart > SAME_SPACE * examples.diagonal() {
        return Err(EvaluateError::RestMesh { percent: 100.0 * apart / examples.diagonal() });
    }
    Ok(envelope)
}

/// Measures a model on frames of the examples.
///
/// # Errors
/// Those of [`open`], [`EvaluateError::NoFrames`], [`EvaluateError::Examples`] and
/// [`EvaluateError::Frame`].
pub fn evaluate(
    model: &[u8],
    examples: &Examples,
    frames: Frames,
) -> Result<Evaluation, EvaluateError> {
    let envelope = open(model, examples)?;
    let chosen = frames.measurable(examples)?;
    let measured = Measured::model(&envelope, examples, &chosen)?;
    let lbs = Measured::lbs(&Lbs::fit(examples), examples, &chosen);
    Ok(Evaluation::new(frames, (&envelope, model.len()), &measured, &lbs))
}

impl Evaluation {
    /// Summarises what was measured of an envelope in a file of so many bytes, and of LBS.
    pub fn new(
        frames: Frames,
        (envelope, model_bytes): (&Envelope<'_>, usize),
        measured: &Measured,
        lbs: &Measured,
    ) -> Self {
        Self {
            split: frames.name(),
            frames: measured.frames.len(),
            vertices: envelope.vertex_len(),
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
