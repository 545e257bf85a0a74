//! Baselines of a model on the same frames: LBS with fitted weights, and LBS with the artist's own weights.

use super::{Measured, TrainingRecord};
use crate::envelope::lbs::blend::Weights;
use crate::envelope::lbs::prior::own_weights;
use crate::envelope::lbs::weights;
use crate::examples::Examples;
use nalgebra::Vector3;

/// Name of the baseline with weights fitted to the training frames.
pub const LBS: &str = "LBS, fitted";
/// Name of the baseline with the mesh's own weights.
pub const OWN_WEIGHTS: &str = "own weights";

/// A baseline and its errors.
pub struct MeasuredBaseline {
    /// The baseline.
    pub baseline: Baseline,
    /// The errors.
    pub measured: Measured,
}

/// The baselines of examples, on the same frames.
pub struct Baselines {
    /// LBS with 4 influences, fitted to the training frames.
    pub lbs: MeasuredBaseline,
    /// LBS with [`own_weights`]; `None` if the mesh comes without weights.
    pub own_weights: Option<MeasuredBaseline>,
}

impl Baselines {
    /// Measures the baselines on frames of the examples. The fitted baseline comes from the model's record if the
    /// record has LBS weights.
    pub fn new(record: &TrainingRecord, examples: &Examples, frames: &[usize]) -> Self {
        let measured = |baseline: Baseline| {
            let measured = Measured::lbs(&baseline, examples, frames);
            MeasuredBaseline { baseline, measured }
        };
        let lbs = record.baseline(examples);
        let own = own_weights(examples, &lbs.weights);
        Self {
            own_weights: own.map(|own| measured(Baseline::new(own, examples))),
            lbs: measured(lbs),
        }
    }
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
