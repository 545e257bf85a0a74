//! Skins of one frame: the runtime's, and that of LBS.

use super::EvaluateError;
use crate::envelope::blend::Weights;
use crate::envelope::motion::{Poses, trajectories};
use crate::envelope::weights::{self, BASELINE_INFLUENCES};
use crate::examples::{Examples, Split};
use nalgebra::Vector3;
use sinew_runtime::envelope::{Attribute, Buffer, SkinJob};
use sinew_runtime::{Envelope, Matrix3x4};

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
    let [positions, normals] = skin_on(envelope, &palette, frame)?;
    Ok(Skin { positions, normals, confidence: f64::from(confidence) })
}

/// Skins the mesh on the palette of a frame: positions and normals, 3V floats each.
///
/// # Errors
/// [`EvaluateError::Frame`].
pub fn skin_on(
    envelope: &Envelope<'_>,
    palette: &[Matrix3x4],
    frame: usize,
) -> Result<[Vec<f32>; 2], EvaluateError> {
    let [mut positions, mut normals] = [0, 1].map(|_| vec![0.0; 3 * envelope.vertex_len()]);
    let attribute = |buffer| Some(Attribute { buffer, offset: 0, stride: 3 });
    SkinJob {
        envelope: *envelope,
        palette,
        vertices: 0..envelope.vertex_len(),
        positions: attribute(Buffer::A),
        normals: attribute(Buffer::B),
        tangents: None,
        out_a: &mut positions,
        out_b: &mut normals,
    }
    .run()
    .map_err(|error| EvaluateError::Frame { frame, error })?;
    Ok([positions, normals])
}

/// The baseline: LBS with 4 influences, fitted to the training frames.
pub struct Lbs {
    /// The joint weights of each vertex.
    pub weights: Weights,
    normals: Vec<[f64; 3]>,
}

impl Lbs {
    /// Fits the weights.
    pub fn fit(examples: &Examples) -> Self {
        let training = examples.frames_of(Split::Train);
        let poses = Poses::new(examples, &training);
        let moved = trajectories(examples, &training, &poses);
        let (weights, _) = weights::fit(&examples.rest, &moved, &poses, BASELINE_INFLUENCES);
        Self { weights, normals: examples.rest_normals() }
    }

    /// Gives a vertex's position and normal in a frame.
    ///
    /// # Panics
    /// If the examples have no such frame or vertex.
    pub fn vertex(
        &self,
        examples: &Examples,
        frame: usize,
        vertex: usize,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let (rest, normal) = (&examples.rest[vertex], &self.normals[vertex]);
        weights::skin(&self.weights, examples.pose(frame), vertex, rest, normal)
    }
}
