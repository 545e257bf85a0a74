//! What a model was measured to do, on frames of a split.

use super::baselines::Baselines;
use super::character::Character;
use super::error::EvaluateError;
use super::measured::{Confidence, Errors, Measured};
use super::skin::Baseline;
use super::told::Told;
use crate::examples::{Examples, Split};
use serde::Serialize;

/// What a model was measured to do.
#[derive(Clone, Debug, Serialize)]
pub struct Evaluation {
    /// Which frames.
    pub split: &'static str,
    /// How many.
    pub frames: usize,
    /// How many of them training has read; none where the file does not tell.
    pub read: Option<usize>,
    /// Vertices of the skin, E.
    pub vertices: usize,
    /// Diagonal of the rest pose's bounding box, in units of the input.
    pub diagonal: f64,
    /// The diagonal in millimetres; `None` where the unit is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diagonal_mm: Option<f64>,
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
    /// RMS errors of the meshes that were joined, where there are several, and of the vertices that follow each
    /// joint most in LBS.
    pub regions: Vec<Region>,
    /// 4-influence LBS fitted to the training frames, on the same frames.
    pub lbs: Errors,
    /// LBS by the joint weights that come with the mesh, on the same frames; `None` where there are none. A vertex
    /// without weights takes those of `lbs`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_weights: Option<Errors>,
}

/// A part of the mesh, and its errors.
#[derive(Clone, Debug, Serialize)]
pub struct Region {
    /// What it is: `mesh` or `joint`.
    pub kind: &'static str,
    /// The name of either.
    pub name: String,
    /// How many vertices it has.
    pub vertices: usize,
    /// RMS distance in % of the rest diagonal.
    pub rms_percent: f64,
    /// RMS distance of LBS, fitted.
    pub lbs_rms_percent: f64,
    /// RMS distance of own weights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_weights_rms_percent: Option<f64>,
    /// RMS distance in millimetres; `None` where the unit is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_mm: Option<f64>,
    /// RMS distance of LBS, fitted, in millimetres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lbs_rms_mm: Option<f64>,
    /// RMS distance of own weights in millimetres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_weights_rms_mm: Option<f64>,
}

/// Lists the parts of a mesh that have names: of which kind, the name, and their vertices.
fn regions(examples: &Examples, lbs: &Baseline) -> Vec<(&'static str, String, Vec<usize>)> {
    let meshes = examples.ranges.iter().filter(|_| examples.ranges.len() > 1);
    let meshes = meshes.map(|(name, range)| ("mesh", name.clone(), range.clone().collect()));
    let mut joints = vec![Vec::new(); examples.joint_len()];
    for vertex in 0..examples.vertex_len() {
        lbs.weights.strongest(vertex).into_iter().for_each(|joint| joints[joint].push(vertex));
    }
    let joints = examples.skeleton.names.iter().zip(joints);
    let joints = joints.filter(|(_, own)| !own.is_empty());
    meshes.chain(joints.map(|(name, own)| ("joint", name.clone(), own))).collect()
}

/// Frames to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frames {
    /// Those of one split.
    Of(Split),
    /// Those that the model's training has not read, by what its file tells.
    New,
    /// All.
    All,
}

impl Frames {
    /// The split's name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Frames::Of(split) => split.name(),
            Frames::New => "new",
            Frames::All => "all",
        }
    }

    /// Chooses what a model is best measured on: held-out frames, or else those that its training has not read, or
    /// else those of the training split.
    pub fn usual(examples: &Examples, told: &Told) -> Self {
        let split = [Self::Of(Split::HeldOut), Self::New];
        let first = split.into_iter().find(|frames| !frames.of(examples, told).is_empty());
        first.unwrap_or(Self::Of(Split::Train))
    }

    /// The frames' numbers.
    pub fn of(self, examples: &Examples, told: &Told) -> Vec<usize> {
        let all = 0..examples.frame_len();
        match self {
            Frames::Of(split) => examples.frames_of(split),
            Frames::New => all.filter(|&frame| told.has_read(frame) == Some(false)).collect(),
            Frames::All => all.collect(),
        }
    }

    /// The frames' numbers, of which there must be one at least, and whose joints must be rigid.
    ///
    /// # Errors
    /// [`EvaluateError::NoFrames`] and [`EvaluateError::Examples`].
    pub fn measurable(self, examples: &Examples, told: &Told) -> Result<Vec<usize>, EvaluateError> {
        let frames = self.of(examples, told);
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
    let told = Told::of(model, &character, examples);
    Evaluation::of((&character, model.len()), &told, examples, frames)
}

impl Evaluation {
    /// Measures a character in a file of so many bytes, which tells this of its training.
    ///
    /// # Errors
    /// [`EvaluateError::NoFrames`], [`EvaluateError::Examples`] and [`EvaluateError::Frame`].
    pub fn of(
        (character, model_bytes): (&Character<'_>, usize),
        told: &Told,
        examples: &Examples,
        frames: Frames,
    ) -> Result<Self, EvaluateError> {
        let chosen = frames.measurable(examples, told)?;
        let measured = Measured::model(character, examples, &chosen)?;
        let baselines = Baselines::new(told, examples, &chosen);
        let read = told.read_len(&chosen);
        let of_character = (character, model_bytes, &measured);
        Ok(Self::new((frames, read), of_character, examples, &baselines))
    }

    /// Summarises the errors of a character and of the baselines.
    ///
    /// - `read`: number of the measured frames that training has read.
    /// - `model_bytes`: length of the character's file.
    pub fn new(
        (frames, read): (Frames, Option<usize>),
        (character, model_bytes, measured): (&Character<'_>, usize, &Measured),
        examples: &Examples,
        Baselines { lbs, own_weights }: &Baselines,
    ) -> Self {
        let Character { envelope, skin, .. } = character;
        let region = |(kind, name, own): (&'static str, String, Vec<usize>)| {
            let [rms_percent, lbs_rms_percent] =
                [measured, &lbs.measured].map(|m| m.rms_percent_of(&own));
            let own_weights_rms_percent =
                own_weights.as_ref().map(|of| of.measured.rms_percent_of(&own));
            let mm = |percent: f64| Some(percent / 100.0 * measured.diagonal_mm?);
            Region {
                kind,
                name,
                vertices: own.len(),
                rms_percent,
                lbs_rms_percent,
                own_weights_rms_percent,
                rms_mm: mm(rms_percent),
                lbs_rms_mm: mm(lbs_rms_percent),
                own_weights_rms_mm: own_weights_rms_percent.and_then(mm),
            }
        };
        Self {
            split: frames.name(),
            frames: measured.frames.len(),
            read,
            vertices: skin.vertex_len(),
            diagonal: measured.diagonal,
            diagonal_mm: measured.diagonal_mm,
            errors: measured.errors(),
            confidence: measured.confidence(),
            model_bytes,
            predictor: envelope.predictor().name(),
            proxies: envelope.proxy_len(),
            regions: regions(examples, &lbs.baseline).into_iter().map(region).collect(),
            lbs: lbs.measured.errors(),
            own_weights: own_weights.as_ref().map(|of| of.measured.errors()),
        }
    }
}
