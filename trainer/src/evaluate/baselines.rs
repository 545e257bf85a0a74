//! Baselines of a model, on the same frames: LBS by fitted weights, and LBS by the artist's own weights.

use super::{Baseline, Measured, Told};
use crate::envelope::lbs::prior::own_weights;
use crate::examples::Examples;

/// Name of the baseline that is fitted to the training frames.
pub const LBS: &str = "LBS, fitted";
/// Name of the baseline by the weights that come with the mesh.
pub const OWN_WEIGHTS: &str = "own weights";

/// A baseline and its errors.
pub struct MeasuredBaseline {
    /// Its weights.
    pub baseline: Baseline,
    /// Its errors.
    pub measured: Measured,
}

/// The baselines of examples, on the same frames.
pub struct Baselines {
    /// LBS with 4 influences, fitted to the training frames.
    pub lbs: MeasuredBaseline,
    /// LBS by [`own_weights`]; `None` where the mesh comes without weights.
    pub own_weights: Option<MeasuredBaseline>,
}

impl Baselines {
    /// Measures the baselines on frames of examples. A model that stores its LBS gives the fitted one.
    pub fn new(told: &Told, examples: &Examples, frames: &[usize]) -> Self {
        let measured = |baseline: Baseline| {
            let measured = Measured::lbs(&baseline, examples, frames);
            MeasuredBaseline { baseline, measured }
        };
        let lbs = told.baseline(examples);
        let own = own_weights(examples, &lbs.weights);
        Self {
            own_weights: own.map(|own| measured(Baseline::new(own, examples))),
            lbs: measured(lbs),
        }
    }
}
