//! Skins of one frame: the runtime's, and that of LBS.

use super::{Character, EvaluateError};
use crate::envelope::lbs::blend::Weights;
use crate::envelope::lbs::weights;
use crate::envelope::posed::{joint_confidences, palette, skin_on};
use crate::examples::Examples;
use nalgebra::Vector3;

/// One frame's skin as the runtime writes it.
pub struct SkinnedFrame {
    positions: Vec<f32>,
    normals: Vec<f32>,
    confidence: f64,
}

impl SkinnedFrame {
    /// Positions of the skin's vertices, 3E floats.
    pub fn positions(&self) -> &[f32] {
        &self.positions
    }

    /// Normals of the skin's vertices, 3E floats.
    pub fn normals(&self) -> &[f32] {
        &self.normals
    }

    /// The model's confidence in the pose.
    pub fn confidence(&self) -> f64 {
        self.confidence
    }

    /// Gives a vertex's position and normal.
    ///
    /// # Panics
    /// If `vertex` is not one.
    pub fn vertex(&self, vertex: usize) -> (Vector3<f64>, Vector3<f64>) {
        let of = |floats: &[f32]| Vector3::from_fn(|axis, _| f64::from(floats[3 * vertex + axis]));
        (of(&self.positions), of(&self.normals))
    }
}

/// Skins one frame of the examples with the runtime.
///
/// # Errors
/// [`EvaluateError::Frame`].
pub fn skin(
    character: &Character<'_>,
    examples: &Examples,
    frame: usize,
) -> Result<SkinnedFrame, EvaluateError> {
    let (palette, confidence) = palette(&character.envelope, examples.pose(frame), frame)?;
    let [positions, normals] = skin_on(&character.skin, &palette, frame)?;
    Ok(SkinnedFrame { positions, normals, confidence: f64::from(confidence) })
}

/// Names the joint that doubts a frame's pose most; none where none does.
pub fn most_doubting<'a>(
    character: &Character<'a>,
    examples: &Examples,
    frame: usize,
) -> Option<&'a str> {
    let found = joint_confidences(&character.envelope, examples, frame)?;
    let joint = (0..found.len()).min_by(|&a, &b| found[a].total_cmp(&found[b]))?;
    if found[joint] < 1.0 { character.envelope.joint_name(joint) } else { None }
}

/// A baseline: LBS by some joint weights.
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

    /// Takes the joint weights of the examples' V vertices.
    pub fn new(weights: Weights, examples: &Examples) -> Self {
        Self { weights, normals: examples.surface().normals() }
    }

    /// Gives an engine's vertex's position and normal in a frame.
    ///
    /// # Panics
    /// If the examples have no such frame or vertex.
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
