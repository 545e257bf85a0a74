//! Baselines of a model on the same frames: LBS with fitted weights, and LBS with the artist's own weights.

use super::character::{Baseline, TrainingRecord};
use super::measured::Measured;
use crate::envelope::lbs::prior::own_weights;
use crate::examples::Examples;

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
