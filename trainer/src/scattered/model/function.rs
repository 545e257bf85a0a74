//! The function with its names, in f64.

use super::input::{EvaluationError, Input, features};
use super::output::{Output, finish};
use crate::regression::fade::Fade;
use crate::scattered::solver::variance::Variance;
use crate::scattered::sum::KernelSum;
use sinew_runtime::kernel::{Normalise, QueryRule};

/// A function from named inputs to named outputs.
#[derive(Clone, Debug)]
pub struct KernelModel {
    /// Its name.
    pub name: String,
    /// Its inputs.
    pub inputs: Vec<Input>,
    /// Its outputs.
    pub outputs: Vec<Output>,
    /// The function of the inputs' features.
    pub sum: KernelSum,
    /// Least and greatest of each feature in the samples.
    pub ranges: Vec<[f64; 2]>,
    /// What becomes of a query far from the samples.
    pub query: QueryRule,
    /// How far the centres vouch for a query.
    pub fade: Fade,
    /// Whether outputs are divided by their sum.
    pub normalise: Normalise,
    /// What the variance takes.
    pub variance: Option<Variance>,
    /// What the fit reached.
    pub fit: Figures,
}

/// What a fit reached; the values' units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// RMS of what is left of the values at the samples.
    pub residual_rms: f64,
    /// RMS error of the samples that the others predict.
    pub left_out_rms: f64,
    /// The most that f32 arithmetic may be off by over samples and their box.
    pub bound: f64,
    /// Reciprocal condition of what was solved; 0 where nothing was.
    pub rcond: f64,
}

/// What a function gives at a query.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluated {
    /// Numbers of all outputs.
    pub numbers: Vec<f64>,
    /// How far samples vouch for the query, in [0, 1].
    pub confidence: f64,
}

impl KernelModel {
    /// Evaluates the function.
    ///
    /// # Errors
    /// [`EvaluationError`] of what is given.
    pub fn evaluate(&self, given: &[f64]) -> Result<Evaluated, EvaluationError> {
        let x = self.features(given)?;
        let mut values = self.sum.evaluate(&x);
        let z = self.sum.measured(&self.sum.scaled(&x));
        let confidence = self.fade.confidence(self.sum.squared_distances(&z));
        if self.query == QueryRule::Fade {
            let neutral = self.outputs.iter().flat_map(|output| output.kind.neutral());
            for (value, neutral) in values.iter_mut().zip(neutral) {
                *value = neutral + confidence * (*value - neutral);
            }
        }
        let rotation = |error| EvaluationError::Rotation { input: "neutral".to_owned(), error };
        let numbers = finish(&self.outputs, self.normalise, &values).map_err(rotation)?;
        Ok(Evaluated { numbers, confidence })
    }

    /// Computes features, kept within the samples' where that is the rule.
    fn features(&self, given: &[f64]) -> Result<Vec<f64>, EvaluationError> {
        let mut x = features(&self.inputs, given)?;
        if self.query == QueryRule::Clamp {
            for (x, [low, high]) in x.iter_mut().zip(&self.ranges) {
                *x = x.max(*low).min(*high);
            }
        }
        Ok(x)
    }
}
