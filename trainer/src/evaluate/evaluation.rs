//! The result of a measurement, and the choice of its frames.

use super::character::{Baseline, Character, TrainingRecord};
use super::measured::{Baselines, Confidence, Errors, Measured};
use crate::Error;
use crate::examples::{Examples, Split};
use serde::Serialize;

/// The errors of a model and of the baselines on the same frames.
#[derive(Clone, Debug, Serialize)]
pub struct Evaluation {
    /// Name of the measured frames.
    pub split: &'static str,
    /// Number of frames.
    pub frames: usize,
    /// Number of these frames that the training read; `None` if the file has no record.
    pub read: Option<usize>,
    /// Number of vertices of the skin, E.
    pub vertices: usize,
    /// Diagonal of the rest pose's bounding box, in units of the input.
    pub diagonal: f64,
    /// The diagonal in millimetres; `None` if the unit is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diagonal_mm: Option<f64>,
    /// The model's errors.
    #[serde(flatten)]
    pub errors: Errors,
    /// The model's confidence in the poses.
    pub confidence: Confidence,
    /// Length of the file.
    pub model_bytes: usize,
    /// Name of the predictor.
    pub predictor: &'static str,
    /// Number of proxies, P.
    pub proxies: usize,
    /// RMS errors of parts: each mesh if several were joined, and the vertices that follow each joint most in LBS.
    pub regions: Vec<Region>,
    /// LBS with 4 influences a vertex, fitted to the training frames.
    pub lbs: Errors,
    /// LBS with the mesh's own joint weights; `None` without own weights. A vertex without own weights uses those of
    /// `lbs`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_weights: Option<Errors>,
}

/// A part of the mesh and its errors.
#[derive(Clone, Debug, Serialize)]
pub struct Region {
    /// Kind of part: `mesh` or `joint`.
    pub kind: &'static str,
    /// Name of the mesh or joint.
    pub name: String,
    /// Number of vertices.
    pub vertices: usize,
    /// RMS distance in % of the rest diagonal.
    pub rms_percent: f64,
    /// RMS distance of fitted LBS, in % of the rest diagonal.
    pub lbs_rms_percent: f64,
    /// RMS distance with own weights, in % of the rest diagonal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_weights_rms_percent: Option<f64>,
    /// RMS distance in millimetres; `None` if the unit is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_mm: Option<f64>,
    /// RMS distance of fitted LBS in millimetres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lbs_rms_mm: Option<f64>,
    /// RMS distance with own weights in millimetres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_weights_rms_mm: Option<f64>,
}

/// Lists the named parts of a mesh: kind, name, and vertices.
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
    /// The frames of one split.
    Of(Split),
    /// The frames that the model's training did not read, according to its record.
    New,
    /// All frames.
    All,
}

impl Frames {
    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Frames::Of(split) => split.name(),
            Frames::New => "new",
            Frames::All => "all",
        }
    }

    /// Chooses the best frames to measure a model: held-out frames, else frames that the training did not read, else
    /// training frames.
    pub fn default_for(examples: &Examples, record: &TrainingRecord) -> Self {
        let split = [Self::Of(Split::HeldOut), Self::New];
        let first = split.into_iter().find(|frames| !frames.of(examples, record).is_empty());
        first.unwrap_or(Self::Of(Split::Train))
    }

    /// Lists the indices of the frames.
    pub fn of(self, examples: &Examples, record: &TrainingRecord) -> Vec<usize> {
        let all = 0..examples.frame_len();
        match self {
            Frames::Of(split) => examples.frames_of(split),
            Frames::New => all.filter(|&frame| record.has_read(frame) == Some(false)).collect(),
            Frames::All => all.collect(),
        }
    }

    /// Lists the indices of the frames, and checks that there are frames and that their joints are rigid.
    ///
    /// # Errors
    /// - [`ErrorKind::Missing`](crate::ErrorKind::Missing): there is no frame.
    /// - A joint is not rigid in a frame.
    pub fn measurable(
        self,
        examples: &Examples,
        record: &TrainingRecord,
    ) -> Result<Vec<usize>, Error> {
        let frames = self.of(examples, record);
        if frames.is_empty() {
            return Err(Error::missing(format!("the examples have no {} frame", self.name())));
        }
        examples.check_poses(&frames)?;
        Ok(frames)
    }
}

/// Measures a skin of a model on frames of the examples; the first skin if `skin` is `None`.
///
/// # Errors
/// Those of [`Character::open`], [`Frames::measurable`] and [`Measured::model`].
pub fn evaluate(
    model: &[u8],
    skin: Option<&str>,
    examples: &Examples,
    frames: Frames,
) -> Result<Evaluation, Error> {
    let character = Character::open(model, skin, examples)?;
    let record = TrainingRecord::of(model, &character, examples);
    Evaluation::of((&character, model.len()), &record, examples, frames)
}

impl Evaluation {
    /// Measures a character.
    ///
    /// - `model_bytes`: length of the character's file.
    /// - `record`: record of the character's training.
    ///
    /// # Errors
    /// Those of [`Frames::measurable`] and [`Measured::model`].
    pub fn of(
        (character, model_bytes): (&Character<'_>, usize),
        record: &TrainingRecord,
        examples: &Examples,
        frames: Frames,
    ) -> Result<Self, Error> {
        let chosen = frames.measurable(examples, record)?;
        let measured = Measured::model(character, examples, &chosen)?;
        let baselines = Baselines::new(record, examples, &chosen);
        let read = record.read_len(&chosen);
        let of_character = (character, model_bytes, &measured);
        Ok(Self::new((frames, read), of_character, examples, &baselines))
    }

    /// Summarises the errors of a character and of the baselines.
    ///
    /// - `read`: number of the measured frames that the training read.
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
