//! Measures a baked model: the f32 runtime on the file's bytes against the examples, and LBS
//! beside it.

use crate::envelope::motion::{Poses, trajectories};
use crate::envelope::weights::{self, BASELINE_INFLUENCES};
use crate::examples::{Examples, ExamplesError, Split};
use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;
use sinew_runtime::envelope::{Attribute, Buffer, SkinJob};
use sinew_runtime::{Envelope, EvalError, FormatError, Matrix3x4, Model};

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

/// Errors over the vertices of some frames.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// RMS distance, in units of the input.
    pub rms: f64,
    /// RMS distance in % of the rest diagonal.
    pub rms_percent: f64,
    /// 99th percentile of the distances in % of the rest diagonal.
    pub p99_percent: f64,
    /// Largest distance in % of the rest diagonal.
    pub max_percent: f64,
    /// RMS angle between the normals and those of the posed mesh, in degrees.
    pub normal_rms_degrees: f64,
}

/// A model's confidence in some frames' poses, in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Confidence {
    /// On average.
    pub mean: f64,
    /// In the frame of which it is least certain.
    pub least: f64,
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
}

/// Opens a model's envelope and checks that it was made for the examples' character.
///
/// # Errors
/// [`EvaluateError::Format`], [`EvaluateError::NoEnvelope`], [`EvaluateError::Mismatch`],
/// [`EvaluateError::JointName`].
pub fn open<'a>(model: &'a [u8], examples: &Examples) -> Result<Envelope<'a>, EvaluateError> {
    let envelope = Model::from_bytes(model)?.envelope().ok_or(EvaluateError::NoEnvelope)?;
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
    let chosen = frames.of(examples);
    if chosen.is_empty() {
        return Err(EvaluateError::NoFrames { split: frames.name() });
    }
    examples.check_rigid_in(&chosen)?;
    let diagonal = examples.diagonal();
    let measured = chosen
        .par_iter()
        .map(|&frame| {
            let skin = skin(&envelope, examples, frame)?;
            let measured =
                Distances::measure(examples, frame, |v| (skin.position(v), skin.normal(v)));
            Ok((measured, skin.confidence))
        })
        .collect::<Result<Vec<_>, EvaluateError>>()?;
    let (measured, confidence): (Vec<_>, Vec<f64>) = measured.into_iter().unzip();
    let training = examples.frames_of(Split::Train);
    let poses = Poses::new(examples, &training);
    let moved = trajectories(examples, &training, &poses);
    let (lbs, _) = weights::fit(&examples.rest, &moved, &poses, BASELINE_INFLUENCES);
    drop(moved);
    let normals = examples.rest_normals();
    let baseline: Vec<_> = chosen
        .par_iter()
        .map(|&frame| {
            let pose = examples.pose(frame);
            Distances::measure(examples, frame, |v| {
                weights::skin(&lbs, pose, v, &examples.rest[v], &normals[v])
            })
        })
        .collect();
    Ok(Evaluation {
        split: frames.name(),
        frames: chosen.len(),
        vertices: examples.vertex_len(),
        diagonal,
        errors: summarise(measured, diagonal),
        confidence: Confidence {
            mean: confidence.iter().sum::<f64>() / confidence.len() as f64,
            least: confidence.iter().copied().fold(1.0, f64::min),
        },
        model_bytes: model.len(),
        predictor: envelope.predictor().name(),
        proxies: envelope.proxy_len(),
        lbs: summarise(baseline, diagonal),
    })
}

/// One frame's skin as the runtime writes it.
pub struct Skin {
    positions: Vec<f32>,
    normals: Vec<f32>,
    confidence: f64,
}

impl Skin {
    /// Positions, 3V floats.
    pub fn positions(&self) -> &[f32] {
        &self.positions
    }

    /// Keeps the positions alone.
    pub fn into_positions(self) -> Vec<f32> {
        self.positions
    }

    fn position(&self, vertex: usize) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| f64::from(self.positions[3 * vertex + axis]))
    }

    fn normal(&self, vertex: usize) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| f64::from(self.normals[3 * vertex + axis]))
    }
}

/// Computes the palette of one frame of the examples with the runtime, and its confidence.
///
/// # Errors
/// [`EvaluateError::Frame`].
pub fn palette(
    envelope: &Envelope<'_>,
    examples: &Examples,
    frame: usize,
) -> Result<(Vec<Matrix3x4>, f32), EvaluateError> {
    let pose: Vec<Matrix3x4> =
        examples.pose(frame).iter().map(|m| m.map(|row| row.map(|x| x as f32))).collect();
    let mut workspace = vec![0.0; envelope.workspace_len()];
    let mut palette = vec![Matrix3x4::default(); envelope.palette_len()];
    let confidence = envelope
        .palette(&pose, &mut workspace, &mut palette)
        .map_err(|error| EvaluateError::Frame { frame, error })?;
    Ok((palette, confidence))
}

/// Skins one frame of the examples with the runtime.
///
/// # Errors
/// [`EvaluateError::Frame`].
pub fn skin(
    envelope: &Envelope<'_>,
    examples: &Examples,
    frame: usize,
) -> Result<Skin, EvaluateError> {
    let (palette, confidence) = palette(envelope, examples, frame)?;
    let mut skin = Skin {
        positions: vec![0.0; 3 * envelope.vertex_len()],
        normals: vec![0.0; 3 * envelope.vertex_len()],
        confidence: f64::from(confidence),
    };
    let attribute = |buffer| Some(Attribute { buffer, offset: 0, stride: 3 });
    SkinJob {
        envelope: *envelope,
        palette: &palette,
        vertices: 0..envelope.vertex_len(),
        positions: attribute(Buffer::A),
        normals: attribute(Buffer::B),
        tangents: None,
        out_a: &mut skin.positions,
        out_b: &mut skin.normals,
    }
    .run()
    .map_err(|error| EvaluateError::Frame { frame, error })?;
    Ok(skin)
}

/// Distances of one frame's vertices from the truth, and their normals' angles.
struct Distances {
    positions: Vec<f64>,
    squared_angles: f64,
    angles: usize,
}

impl Distances {
    fn measure(
        examples: &Examples,
        frame: usize,
        skinned: impl Fn(usize) -> (Vector3<f64>, Vector3<f64>),
    ) -> Self {
        let truth = examples.frame(frame);
        let normals = examples.posed_normals(frame);
        let mut all =
            Self { positions: Vec::with_capacity(truth.len()), squared_angles: 0.0, angles: 0 };
        for vertex in 0..truth.len() {
            let (position, normal) = skinned(vertex);
            all.positions.push((position - Vector3::from(truth[vertex])).norm());
            let expected = Vector3::from(normals[vertex]);
            if expected.norm_squared() > 0.0 && normal.norm_squared() > 0.0 {
                let angle = expected.cross(&normal).norm().atan2(expected.dot(&normal));
                all.squared_angles += angle * angle;
                all.angles += 1;
            }
        }
        all
    }
}

fn summarise(frames: Vec<Distances>, diagonal: f64) -> Errors {
    let squared_angles: f64 = frames.iter().map(|f| f.squared_angles).sum();
    let angles: usize = frames.iter().map(|f| f.angles).sum();
    let mut distances: Vec<f64> = frames.into_iter().flat_map(|f| f.positions).collect();
    let count = distances.len().max(1);
    let rms = (distances.iter().map(|d| d * d).sum::<f64>() / count as f64).sqrt();
    // The least distance that 99 % of the vertices do not exceed.
    let rank = (count * 99).div_ceil(100) - 1;
    let p99 = match distances.get(rank) {
        Some(_) => *distances.select_nth_unstable_by(rank, f64::total_cmp).1,
        None => 0.0,
    };
    let percent = |length: f64| 100.0 * length / diagonal;
    Errors {
        rms,
        rms_percent: percent(rms),
        p99_percent: percent(p99),
        max_percent: percent(distances.iter().copied().fold(0.0, f64::max)),
        normal_rms_degrees: (squared_angles / angles.max(1) as f64).sqrt().to_degrees(),
    }
}
