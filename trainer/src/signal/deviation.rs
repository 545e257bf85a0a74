//! How far the file of a function is from it (METHOD §2.7), and what to change where that is too far.

use super::error::{Remedy, SignalError};
use super::functional::Functional;
use super::kriging::Kriging;
use crate::numeric::columns::ends;
use crate::scattered::deviation::{F32_ERROR, Probe};
use crate::scattered::model::{Input, InputKind};
use crate::scattered::sum::KernelSum;

/// A range below this share of the magnitude is that of a constant: a solve in f64 leaves less.
const CONSTANT: f64 = 1e-9;
/// Half a unit in the last place of f32.
const ROUNDING: f64 = 6e-8;
/// Share of the limit above which rounding a number is the reason of a deviation.
const REASON: f64 = 0.25;
/// Least and greatest value whose coefficients and whose square f32 holds.
const LEAST: f64 = 1e-30;
const MOST: f64 = 1e18;

/// A function at the places where it was observed, to compare its file with.
pub struct Compared<'a> {
    fit: &'a Kriging,
    /// Where observations begin and end.
    places: Vec<f64>,
    /// The least and the greatest value there.
    values: [f64; 2],
    range: f64,
    limit: f64,
}

impl<'a> Compared<'a> {
    /// Evaluates a fit of functionals.
    ///
    /// - `limit`: the largest deviation of the file that is allowed, over the function's range. The range of a constant is
    ///   its magnitude. Where all is observed at one place the range is at least the standard deviation of the process.
    pub fn new(functionals: &[Functional], fit: &'a Kriging, limit: f64) -> Self {
        let places: Vec<f64> = functionals.iter().flat_map(Functional::ends).collect();
        let found: Vec<f64> = places.iter().map(|at| value(fit, *at)).collect();
        let values @ [least, most] = ends(&found);
        let magnitude = least.abs().max(most.abs());
        let one_place = places.iter().all(|place| *place == places[0]);
        let own = if one_place { fit.variance().sqrt() } else { 0.0 };
        let range = match (most - least).max(own) {
            range if range > CONSTANT * magnitude => range,
            _ if magnitude > 0.0 => magnitude,
            _ => 1.0,
        };
        Self { fit, places, values, range, limit }
    }

    /// Measures how far a file is off where the function was observed and at 1,000 places between, over its range.
    ///
    /// # Errors
    /// [`SignalError::Empty`] without places.
    pub fn deviation(&self, sum: &KernelSum) -> Result<f64, SignalError> {
        let sites: Vec<Vec<f64>> = self.places.iter().map(|place| vec![*place]).collect();
        // Places that were fitted are finite.
        let probe = Probe::new(&[input()], &sites, vec![self.range], self.limit);
        let probe = probe.map_err(|_| SignalError::Empty)?;
        Ok(probe.deviation(sum, |x| x.iter().map(|at| value(self.fit, *at)).collect()))
    }

    /// Measures the same, and refuses a deviation above the limit.
    ///
    /// - `change`: what helps where f32 holds all numbers.
    ///
    /// # Errors
    /// [`SignalError::Deviation`], and those of [`Self::deviation`].
    pub fn check(&self, sum: &KernelSum, change: &'static str) -> Result<f64, SignalError> {
        let (deviation, limit) = (self.deviation(sum)?, self.limit);
        if deviation <= limit {
            return Ok(deviation);
        }
        let remedy = self.unheld(deviation).unwrap_or(Remedy::Covariance(change));
        Err(SignalError::Deviation { deviation, limit, remedy })
    }

    /// Returns what helps where f32 does not hold numbers well enough for the limit; none where it does.
    pub fn unheld(&self, deviation: f64) -> Option<Remedy> {
        let reason = REASON * self.limit * self.range;
        let [least, most] = self.values;
        let magnitude = least.abs().max(most.abs());
        if deviation.is_infinite() {
            return Some(Remedy::Units);
        }
        if let Some(remedy) = unheld(magnitude, self.range, reason) {
            return Some(remedy);
        }
        // The place where a change of the input changes the value most.
        let moved = |by: &dyn Fn(f64) -> f64| {
            let off = |at: &f64| (value(self.fit, at + by(*at)) - value(self.fit, *at)).abs();
            let found = self.places.iter().map(|at| (off(at), *at));
            let most = found.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(off, _)| *off > reason);
            most.map(|(_, at)| (at, by(at).abs()))
        };
        let (_, _, [middle, _]) = self.fit.coefficients();
        let [low, high] = ends(&self.places);
        let read = moved(&|at| f64::from(at as f32) - at);
        match read {
            Some((at, by)) if middle.abs() > high - low => Some(Remedy::Inputs(at, by)),
            _ => read
                .or_else(|| moved(&|at| ROUNDING * (at - middle)))
                .map(|(at, by)| Remedy::Apart(at, by)),
        }
    }
}

/// Returns what helps where f32 rounds samples of a signal by more than a thousandth of their range; none where it does
/// not, and of a constant.
pub fn unheld_samples(samples: &[f64]) -> Option<Remedy> {
    let [least, most] = ends(samples);
    let (magnitude, range) = (least.abs().max(most.abs()), most - least);
    let is_constant = range <= CONSTANT * magnitude;
    (!is_constant).then(|| unheld(magnitude, range, F32_ERROR * range)).flatten()
}

/// Returns what helps where f32 rounds values by more than is allowed, or does not hold their squares.
fn unheld(magnitude: f64, range: f64, allowed: f64) -> Option<Remedy> {
    let rounding = ROUNDING * magnitude;
    if !(LEAST..=MOST).contains(&magnitude) {
        return Some(Remedy::Units);
    }
    let is_far = rounding > allowed && magnitude > range;
    is_far.then(|| Remedy::Values(f64::from(magnitude as f32), rounding))
}

/// Returns the input of a function.
pub fn input() -> Input {
    Input { name: "x".to_owned(), kind: InputKind::Scalar, weight: 1.0 }
}

fn value(fit: &Kriging, at: f64) -> f64 {
    fit.value(&Functional::Value { at })
}
