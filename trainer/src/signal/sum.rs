//! Represents a fitted function as a sum of kernels, and measures the deviation of its file (METHOD §2.7).
//!
//! A value contributes one kernel at its place. An average contributes an integral of kernels, by quadrature: one
//! kernel per node. A derivative contributes a central difference of eight kernels. Averages and derivatives reach the
//! accuracy of f32 only with the Gaussian, which is infinitely differentiable.

use super::covariance::Covariance;
use super::faults::{no_observations, wrong_number};
use super::functional::{Functional, NODES, nodes};
use super::kriging::{Kriging, Process};
use crate::Error;
use crate::numeric::columns::ends;
use crate::scattered::bound::rounded;
use crate::scattered::deviation::{F32_ERROR, Probe};
use crate::scattered::model::{Input, InputKind};
use crate::scattered::sum::{KernelSum, Term};
use faer::Mat;
use std::fmt::{Display, Formatter};

/// Right half of the central difference of order 8.
const DIFFERENCE: [f64; 4] = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
/// Step of the difference, in the kernel's unit of distance. Its error is 2e-8 of a derivative, and f32 rounding adds
/// 1e-6. A power of 2 keeps f32 places exact.
const STEP: f64 = 0.0625;
/// Longest box per quadrature, in the kernel's unit of distance.
const PIECE: f64 = std::f64::consts::SQRT_2;
/// Most kernels of a function's averages: 8 MB.
const CENTRES: f64 = 1e6;

/// Values whose range is below this fraction of their magnitude count as constant; the errors of an f64 solve are
/// smaller.
const CONSTANT: f64 = 1e-9;
/// Half a unit in the last place of f32.
const ROUNDING: f64 = 6e-8;
/// Fraction of the allowed deviation above which rounding counts as the cause.
const REASON: f64 = 0.25;
/// Least and greatest value for which f32 represents the coefficients and squares.
const LEAST: f64 = 1e-30;
const MOST: f64 = 1e18;

/// Converts a fit to kernels, rounded to f32.
///
/// - `numbers`: original number of each observation, n, for messages.
///
/// # Errors
/// - If the covariance has no kernel.
/// - If there are derivatives or averages, and the covariance is not Gaussian.
/// - If averages need too many kernels.
/// - If the length is outside the range of f32.
pub fn sum(
    process: &Process,
    functionals: &[Functional],
    numbers: &[usize],
    fit: &Kriging,
) -> Result<KernelSum, Error> {
    let refused = |what: String| {
        Error::unsupported(format!(
            "no part kernel holds {what}: it can hold values with covariance squared exponential, ornstein-uhlenbeck, \
             matern 3/2 or matern 5/2, and derivatives and averages with squared exponential"
        ))
    };
    let name = process.covariance.name();
    let Some((kernel, epsilon)) = process.covariance.kernel() else {
        return Err(refused(format!("covariance {name}")));
    };
    let smooth = matches!(process.covariance, Covariance::SquaredExponential { .. });
    let is_other = |of: &Functional| !smooth && !matches!(of, Functional::Value { .. });
    if let Some(at) = functionals.iter().position(is_other) {
        let number = numbers.get(at).unwrap_or(&at);
        return Err(refused(format!(
            "observation {number}, which is no value, with covariance {name}"
        )));
    }
    let length = if smooth { 0.5f64.sqrt() / epsilon } else { 1.0 / epsilon };
    // The runtime rounds epsilon too. With the rounded value, centres coincide with inputs at the same place.
    let epsilon = f64::from(epsilon as f32);
    if !(f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX)).contains(&epsilon) {
        let expected = "a number from 1e-37 to 1e37, as single precision holds it";
        return Err(wrong_number("length", expected, length));
    }
    let (kernels, terms, [middle, scale]) = fit.coefficients();
    // Without a shift, and with a power of 2 as scale, inputs are not rounded. A line far from 0 still needs the shift.
    let is_power = epsilon.to_bits() << 12 == 0;
    let is_near = terms.len() < 2 || (middle * scale).abs() <= 2.0;
    let shift = if is_power && is_near { 0.0 } else { middle };
    let place = |at: f64| f64::from((f64::from((at - shift) as f32) * epsilon) as f32);
    let boxes = functionals.iter().map(|of| pieces(of.ends().map(place)));
    let len = NODES as f64 * boxes.sum::<f64>();
    if len > CENTRES {
        return Err(Error::limit(format!(
            "no part kernel holds averages that take {len:.0} centres: it can hold 1,000,000: take a longer length"
        )));
    }
    let centres: Vec<(f64, f64)> = functionals
        .iter()
        .zip(kernels)
        .flat_map(|(of, c)| centres(of, c, place, epsilon))
        .collect();
    let mut numbers: Vec<f64> = centres.iter().map(|(_, c)| *c).collect();
    // The mean's line is in (x - middle) scale, the polynomial's line in (x - shift) epsilon.
    match terms[..] {
        [constant, line] => {
            numbers.extend([constant + line * (shift - middle) * scale, line * scale / epsilon]);
        }
        _ => numbers.extend(&terms),
    }
    let basis = [Term::One, Term::Product { earlier: 0, input: 0 }];
    Ok(rounded(&KernelSum {
        kernel,
        shift: vec![shift],
        scale: vec![epsilon],
        metric: None,
        centres: Mat::from_fn(1, centres.len(), |_, k| centres[k].0),
        terms: basis[..terms.len()].to_vec(),
        coefficients: Mat::from_fn(1, numbers.len(), |_, k| numbers[k]),
    }))
}

/// Lists the kernels of a functional's covariance times `c`, as (centre, coefficient).
///
/// - `place`: subtracts the shift from a place and multiplies by `epsilon`, as the runtime does.
fn centres(of: &Functional, c: f64, place: impl Fn(f64) -> f64, epsilon: f64) -> Vec<(f64, f64)> {
    match *of {
        Functional::Value { at } => vec![(place(at), c)],
        Functional::Derivative { at } => {
            let (middle, slope) = (place(at), c * epsilon / STEP);
            let both = |(k, share): (usize, &f64)| {
                let off = (k + 1) as f64 * STEP;
                [(middle + off, slope * share), (middle - off, -slope * share)]
            };
            DIFFERENCE.iter().enumerate().flat_map(both).collect()
        }
        Functional::Average { from, to } => {
            let [from, to] = [from, to].map(place);
            let pieces = pieces([from, to]).max(1.0);
            let side = (to - from) / pieces;
            let piece = |k: usize| {
                let start = from + side * k as f64;
                nodes(start, start + side).map(move |(at, share)| (at, c * share / pieces))
            };
            (0..pieces as usize).flat_map(piece).collect()
        }
    }
}

/// Counts the quadratures of a box; ends are in the kernel's unit of distance.
fn pieces([from, to]: [f64; 2]) -> f64 {
    ((to - from) / PIECE).ceil()
}

/// Suggested change if the baked function deviates too much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Remedy {
    /// Change the units: f32 overflows or underflows.
    Units,
    /// Subtract an offset from the values. Fields: a value and its f32 rounding error.
    Values(f64, f64),
    /// Subtract an offset from the inputs. Fields: an input and its f32 rounding error.
    Inputs(f64, f64),
    /// Split the function: some inputs are close together and others far away. Fields: an input and its f32 rounding
    /// error.
    Apart(f64, f64),
    /// Change the covariance, as the text says.
    Covariance(&'static str),
}

impl Display for Remedy {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let (what, at, by, then) = match *self {
            Self::Units => {
                return f.write_str("give inputs and values in units in which they are near 1");
            }
            Self::Covariance(change) => return f.write_str(change),
            Self::Values(at, by) => ("values", at, by, "take an offset off the values"),
            Self::Inputs(at, by) => ("inputs", at, by, "take an offset off the inputs"),
            Self::Apart(at, by) => {
                ("inputs", at, by, "fit inputs so far apart as functions of their own")
            }
        };
        write!(f, "{what} near {at} are rounded by {by:.1e}: {then}")
    }
}

/// A fitted function and its values at the observations, to compare with its file.
pub struct Compared<'a> {
    fit: &'a Kriging,
    /// Start and end of every observation.
    places: Vec<f64>,
    /// Least and greatest value at these places.
    values: [f64; 2],
    range: f64,
    limit: f64,
}

impl<'a> Compared<'a> {
    /// Evaluates a fit at the ends of its functionals.
    ///
    /// - `limit`: largest allowed deviation of the file, relative to the function's range. A constant's range is its
    ///   magnitude. If all observations are at one place, the range is at least the standard deviation of the process.
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

    /// Measures the largest deviation of the file, relative to the function's range: at the observations and at 1,000
    /// places between. Also returns the suggested change for a deviation above the limit.
    ///
    /// - `change`: suggested change if f32 rounding is not the cause.
    ///
    /// # Errors
    /// If there are no places.
    pub fn deviation(
        &self,
        sum: &KernelSum,
        change: &'static str,
    ) -> Result<(f64, Option<Remedy>), Error> {
        let sites: Vec<Vec<f64>> = self.places.iter().map(|place| vec![*place]).collect();
        // A fit's places are finite, so the probe fails only without places.
        let probe = Probe::new(&[input()], &sites, vec![self.range], self.limit);
        let probe = probe.map_err(|_| no_observations())?;
        let deviation = probe.deviation(sum, |x| x.iter().map(|at| value(self.fit, *at)).collect());
        let remedy = || self.rounding_remedy(deviation).unwrap_or(Remedy::Covariance(change));
        // NaN is above the limit.
        let is_within = deviation <= self.limit;
        Ok((deviation, (!is_within).then(remedy)))
    }

    /// Returns the suggested change if f32 rounding causes the deviation; `None` otherwise.
    fn rounding_remedy(&self, deviation: f64) -> Option<Remedy> {
        let reason = REASON * self.limit * self.range;
        let [least, most] = self.values;
        let magnitude = least.abs().max(most.abs());
        if deviation.is_infinite() {
            return Some(Remedy::Units);
        }
        if let Some(remedy) = magnitude_remedy(magnitude, self.range, reason) {
            return Some(remedy);
        }
        // Finds the place where rounding the input changes the value most.
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

/// Returns the suggested change if f32 rounds samples by more than a thousandth of their range; `None` otherwise and
/// for constants.
pub fn samples_remedy(samples: &[f64]) -> Option<Remedy> {
    let [least, most] = ends(samples);
    let (magnitude, range) = (least.abs().max(most.abs()), most - least);
    let is_constant = range <= CONSTANT * magnitude;
    (!is_constant).then(|| magnitude_remedy(magnitude, range, F32_ERROR * range)).flatten()
}

/// Returns the suggested change if f32 rounds values by more than `allowed` or cannot represent their squares.
fn magnitude_remedy(magnitude: f64, range: f64, allowed: f64) -> Option<Remedy> {
    let rounding = ROUNDING * magnitude;
    if !(LEAST..=MOST).contains(&magnitude) {
        return Some(Remedy::Units);
    }
    let is_far = rounding > allowed && magnitude > range;
    is_far.then(|| Remedy::Values(f64::from(magnitude as f32), rounding))
}

/// Returns the function's single input.
pub fn input() -> Input {
    Input { name: "x".to_owned(), kind: InputKind::Scalar, weight: 1.0 }
}

fn value(fit: &Kriging, at: f64) -> f64 {
    fit.value(&Functional::Value { at })
}
