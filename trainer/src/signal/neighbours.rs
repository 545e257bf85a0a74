//! Predictions from the observations that are nearest: what a global system is too large for (METHOD §4).

use super::error::SignalError;
use super::functional::Functional;
use super::kriging::{Kriging, Prediction, Process};

/// Observations, of which each prediction takes the nearest.
pub struct Neighbours<'a> {
    /// What the function is thought to be.
    pub process: &'a Process,
    /// What is observed, n.
    pub functionals: &'a [Functional],
    /// What was found, n.
    pub values: &'a [f64],
    /// How many count.
    pub count: usize,
}

impl Neighbours<'_> {
    /// Predicts a functional from the nearest by their middles; of two as near the earlier one.
    ///
    /// # Errors
    /// Those of [`Kriging::new`].
    pub fn predict(&self, of: &Functional) -> Result<Prediction, SignalError> {
        let mut order: Vec<usize> = (0..self.functionals.len()).collect();
        let distance = |i: &usize| (self.functionals[*i].middle() - of.middle()).abs();
        order.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        order.truncate(self.count);
        order.sort_unstable();
        let near: Vec<Functional> = order.iter().map(|i| self.functionals[*i]).collect();
        let values: Vec<f64> = order.iter().filter_map(|i| self.values.get(*i).copied()).collect();
        Ok(Kriging::new(self.process, &near, &values)?.predict(of))
    }
}
