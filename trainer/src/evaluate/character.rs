//! What is measured: an envelope with a skin, the skinned mesh of a frame, a baseline, and the record of the training.

use crate::Error;
use crate::envelope::lbs::blend::Weights;
use crate::envelope::lbs::weights;
use crate::envelope::posed::{Pose, joint_confidences, palette, rest, skin_on};
use crate::examples::{Examples, is_same};
use crate::numeric::affine::{apart, apart_unordered};
use nalgebra::Vector3;
use sinew_runtime::format::Space;
use sinew_runtime::{Envelope, Model, Record, Skin};

/// An envelope and a skin that follows the envelope.
#[derive(Clone, Copy, Debug)]
pub struct Character<'a> {
    /// Predicts the palette.
    pub envelope: Envelope<'a>,
    /// Follows the palette.
    pub skin: Skin<'a>,
    /// The space of both.
    pub space: Space,
}

/// Largest RMS distance between two rest meshes in the same space, as a share of the diagonal. Other axes and units
/// give a larger distance. A mesh that was sculpted again has a smaller distance and shows as an error.
const SAME_SPACE: f64 = 0.05;
/// Largest RMS distance between vertices at the same positions, as a share of the diagonal: the rounding of single
/// precision.
const SAME_PLACES: f64 = 1e-4;

impl<'a> Character<'a> {
    /// Finds a skin by name, or the first skin, and the envelope that the skin follows.
    ///
    /// # Errors
    /// - [`ErrorKind::Damaged`](crate::ErrorKind::Damaged): the runtime refuses the model.
    /// - [`ErrorKind::Missing`](crate::ErrorKind::Missing): the model does not hold the skin, or an envelope that moves
    ///   it.
    pub fn find(model: &'a [u8], skin: Option<&str>) -> Result<Self, Error> {
        let loaded = Model::from_bytes(model)
            .map_err(|error| Error::from(error).within("the model is refused"))?;
        let found = match skin {
            None => loaded.first::<Skin>(),
            Some(name) => loaded.named::<Skin>(name),
        };
        let Some(found) = found else {
            let has: Vec<&str> = loaded.all::<Skin>().map(|skin| skin.name()).collect();
            return Err(match (skin, has.is_empty()) {
                (Some(name), false) => Error::missing(format!(
                    "the model holds no skin called {name}; it has: {}",
                    has.join(", ")
                )),
                _ if loaded.first::<Envelope>().is_some() => Error::missing(
                    "the model holds a palette alone, without a skin to measure or to play: train one without \
                     --no-skin for that",
                ),
                _ => no_envelope(),
            });
        };
        // The views borrow the loaded model; opening their layouts borrows the bytes instead.
        let envelope = loaded.envelope_of(&found).and_then(|e| e.layout().open(model));
        let (envelope, skin) = envelope.zip(found.layout().open(model)).ok_or_else(no_envelope)?;
        Ok(Self { envelope, skin, space: loaded.space() })
    }

    /// Finds a skin as [`Character::find`] does, and checks that the skin was made for the examples' character.
    ///
    /// # Errors
    /// - The errors of [`Character::find`].
    /// - [`ErrorKind::Mismatch`](crate::ErrorKind::Mismatch): the number of vertices or joints, the name of a joint, or
    ///   the rest mesh differs.
    pub fn open(model: &'a [u8], skin: Option<&str>, examples: &Examples) -> Result<Self, Error> {
        let character = Self::find(model, skin)?;
        let Self { envelope, skin, .. } = &character;
        let (expected, found) = (skin.vertex_len(), examples.surface().engine_len());
        if expected != found {
            return Err(Error::mismatch(format!(
                "the model has {expected} vertices, the examples have {found}: give examples of the file that training had, \
                 with its texture's seams where that has them"
            )));
        }
        let joint_names = match examples.skeleton.is_still {
            true => &[],
            false => &examples.skeleton.names[..],
        };
        let (expected, found) = (envelope.joint_len(), joint_names.len());
        if expected != found {
            return Err(Error::mismatch(format!(
                "the model has {expected} joints, the examples have {found}: give examples of the skeleton that training had"
            )));
        }
        for (joint, found) in joint_names.iter().enumerate() {
            let expected = envelope.joint_name(joint).unwrap_or_default();
            if expected != found {
                return Err(Error::mismatch(format!(
                    "joint {joint} is called {expected} in the model, {found} in the examples"
                )));
            }
        }
        for curve in (0..envelope.curve_len()).filter_map(|curve| envelope.curve_name(curve)) {
            if !examples.curve_names.iter().any(|name| name == curve) {
                return Err(Error::mismatch(format!(
                    "the model follows curve {curve}, which the examples lack: give examples with the curves that training \
                     had"
                )));
            }
        }
        let expected = examples.surface().copied(&examples.rest);
        let (found_rest, diagonal) = (rest(skin), examples.diagonal());
        let apart = apart(&found_rest, &expected);
        if apart > SAME_SPACE * diagonal {
            if apart_unordered(&found_rest, &expected) <= SAME_PLACES * diagonal {
                return Err(Error::mismatch(
                    "the model's rest mesh has the vertices of the examples in another order, as FBX and glTF of one character \
                     do: give the file that training had, or one that has its order",
                ));
            }
            return Err(Error::mismatch(format!(
                "the model's rest mesh is not that of the examples: off by {:.1} % of the diagonal; \
                 give the examples as they were given in training, with the same --targets, and say what their \
                 file does not by --up, --forward and --unit",
                100.0 * apart / diagonal
            )));
        }
        Ok(character)
    }
}

fn no_envelope() -> Error {
    Error::missing("the model holds no envelope that moves a skin")
}

/// The skinned mesh of one frame, as the runtime writes it.
pub struct SkinnedFrame {
    /// Positions of the skin's vertices, 3E floats.
    pub positions: Vec<f32>,
    /// Normals of the skin's vertices, 3E floats.
    pub normals: Vec<f32>,
    /// The model's confidence in the pose, in [0, 1].
    pub confidence: f64,
}

impl SkinnedFrame {
    /// Returns the position and normal of a vertex.
    ///
    /// # Panics
    /// If there is no such vertex.
    pub fn vertex(&self, vertex: usize) -> (Vector3<f64>, Vector3<f64>) {
        let of = |floats: &[f32]| Vector3::from_fn(|axis, _| f64::from(floats[3 * vertex + axis]));
        (of(&self.positions), of(&self.normals))
    }
}

/// Skins one frame of the examples with the runtime.
///
/// # Errors
/// The runtime refuses the frame.
pub fn skin(
    character: &Character<'_>,
    examples: &Examples,
    frame: usize,
) -> Result<SkinnedFrame, Error> {
    let (palette, confidence) =
        palette(&character.envelope, &Pose::of(&character.envelope, examples, frame), frame)?;
    let [positions, normals] = skin_on(&character.skin, &palette, frame)?;
    Ok(SkinnedFrame { positions, normals, confidence: f64::from(confidence) })
}

/// Returns the joint with the lowest confidence in a frame's pose; `None` if all joints are certain.
pub fn least_confident_joint<'a>(
    character: &Character<'a>,
    examples: &Examples,
    frame: usize,
) -> Option<&'a str> {
    let found = joint_confidences(&character.envelope, examples, frame)?;
    let joint = (0..found.len()).min_by(|&a, &b| found[a].total_cmp(&found[b]))?;
    if found[joint] < 1.0 { character.envelope.joint_name(joint) } else { None }
}

/// A baseline: LBS with some joint weights.
pub struct Baseline {
    /// The joint weights of each vertex.
    pub weights: Weights,
    normals: Vec<[f64; 3]>,
}

impl Baseline {
    /// Fits weights to the training frames, 4 a vertex.
    pub fn fit(examples: &Examples) -> Self {
        Self::new(weights::baseline(examples), examples)
    }

    /// Makes a baseline from joint weights of the V vertices.
    pub fn new(weights: Weights, examples: &Examples) -> Self {
        Self { weights, normals: examples.surface().normals() }
    }

    /// Returns the position and normal of an engine vertex in a frame.
    ///
    /// # Panics
    /// If the examples do not have the frame or the vertex.
    pub fn vertex(
        &self,
        examples: &Examples,
        frame: usize,
        vertex: usize,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let normal = &self.normals[vertex];
        let vertex = examples.surface().copy_of(vertex);
        weights::skin(&self.weights, examples.pose(frame), vertex, &examples.rest[vertex], normal)
    }
}

/// The record of a model's training, matched to examples.
#[derive(Default)]
pub struct TrainingRecord {
    /// Whether the training read each frame of the examples, N; `None` without a record.
    read: Option<Vec<bool>>,
    /// Weights of LBS as the training fitted them.
    lbs: Option<Weights>,
}

impl TrainingRecord {
    /// Reads the record of a character's envelope; empty if the model holds no record.
    pub fn of(model: &[u8], character: &Character<'_>, examples: &Examples) -> Self {
        let Ok(loaded) = Model::from_bytes(model) else { return Self::default() };
        let record = loaded.named::<Record>(character.envelope.name());
        let Some(record) = record else { return Self::default() };
        let marks: Vec<_> = record.frame_marks().collect();
        let has_read = |frame| {
            let own = examples.mark(frame);
            marks.iter().any(|mark| is_same(mark, &own))
        };
        Self {
            read: Some((0..examples.frame_len()).map(has_read).collect()),
            lbs: lbs_weights(&record, examples),
        }
    }

    /// Returns whether the training read a frame; `None` without a record.
    pub fn has_read(&self, frame: usize) -> Option<bool> {
        self.read.as_ref().and_then(|read| read.get(frame)).copied()
    }

    /// Counts the frames that the training read; `None` without a record.
    pub fn read_len(&self, frames: &[usize]) -> Option<usize> {
        let read = self.read.as_ref()?;
        Some(frames.iter().filter(|&&frame| read[frame]).count())
    }

    /// Returns LBS as the training fitted it, or fitted to the examples' training frames if the record has no weights.
    pub fn baseline(&self, examples: &Examples) -> Baseline {
        match &self.lbs {
            Some(weights) => Baseline::new(weights.clone(), examples),
            None => Baseline::fit(examples),
        }
    }
}

/// Reads joint weights of the examples' vertices; `None` if the record has none or is of another mesh.
fn lbs_weights(record: &Record<'_>, examples: &Examples) -> Option<Weights> {
    let counts = record.counts();
    let is_own = counts.vertex_len as usize == examples.vertex_len()
        && counts.joint_len as usize == examples.joint_len();
    if !is_own || counts.influence_len == 0 {
        return None;
    }
    let list = |vertex| {
        let own = record.lbs_influences(vertex)?;
        let own: Vec<(usize, f64)> = own.map(|(joint, w)| (joint, f64::from(w))).collect();
        let sum: f64 = own.iter().map(|(_, weight)| weight).sum();
        Some(own.into_iter().map(|(joint, weight)| (joint, weight / sum)).collect())
    };
    let lists: Option<Vec<_>> = (0..examples.vertex_len()).map(list).collect();
    Some(Weights::from_lists(counts.influence_len as usize, lists?.into_iter()))
}
