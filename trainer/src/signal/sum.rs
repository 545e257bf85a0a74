//! A function of observations as a sum of kernels, where the kernel library can express it.
//!
//! The covariance with a value is a kernel about its place. That with an average is an integral of kernels, whose
//! quadrature is a kernel at each node. That with a derivative is the limit of a difference of eight kernels. Both are
//! as good as f32 only where the kernel is smooth without end: the gaussian.

use super::covariance::Covariance;
use super::error::SignalError;
use super::functional::{Functional, NODES, nodes};
use super::kriging::{Kriging, Process};
use crate::scattered::bound::rounded;
use crate::scattered::sum::{KernelSum, Term};
use faer::Mat;

/// Half a central difference of order 8, by steps from the middle.
const DIFFERENCE: [f64; 4] = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
/// Its step, as the kernel measures distances: it is off by 2e-8 of a derivative, and f32 rounds 1e-6. As a power of 2
/// it goes between numbers of f32.
const STEP: f64 = 0.0625;
/// Longest box that one quadrature is taken of, as the kernel measures distances.
const PIECE: f64 = std::f64::consts::SQRT_2;
/// Most kernels of a function's averages: 8 MB.
const CENTRES: f64 = 1e6;

/// Makes the kernels of a fit, rounded to f32.
///
/// - `numbers`: the number of each observation as it is written, n.
///
/// # Errors
/// [`SignalError::NoKernel`] of a covariance that is no kernel, of derivatives and averages of one that is not the
/// gaussian, and of averages that take too many kernels; [`SignalError::Number`] of a length that f32 does not hold.
pub fn sum(
    process: &Process,
    functionals: &[Functional],
    numbers: &[usize],
    fit: &Kriging,
) -> Result<KernelSum, SignalError> {
    let refused = |what: String| SignalError::NoKernel {
        what,
        can: "values with covariance squared exponential, ornstein-uhlenbeck, matern 3/2 or matern 5/2, and \
              derivatives and averages with squared exponential",
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
    // Rounded as the runtime does it, so that a centre is where an input of its place comes to lie.
    let epsilon = f64::from(epsilon as f32);
    if !(f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX)).contains(&epsilon) {
        let expected = "a number from 1e-37 to 1e37, as single precision holds it";
        return Err(SignalError::Number { what: "length", expected, found: length });
    }
    let (kernels, terms, [middle, scale]) = fit.coefficients();
    // Nothing is rounded where nothing is taken off inputs and they are multiplied by a power of 2. A line far from 0
    // needs its middle.
    let is_power = epsilon.to_bits() << 12 == 0;
    let is_near = terms.len() < 2 || (middle * scale).abs() <= 2.0;
    let shift = if is_power && is_near { 0.0 } else { middle };
    let place = |at: f64| f64::from((f64::from((at - shift) as f32) * epsilon) as f32);
    let boxes = functionals.iter().map(|of| pieces(of.ends().map(place)));
    let len = NODES as f64 * boxes.sum::<f64>();
    if len > CENTRES {
        let what = format!("averages that take {len:.0} centres");
        return Err(SignalError::NoKernel { what, can: "1,000,000: take a longer length" });
    }
    let centres: Vec<(f64, f64)> = functionals
        .iter()
        .zip(kernels)
        .flat_map(|(of, c)| centres(of, c, place, epsilon))
        .collect();
    let mut numbers: Vec<f64> = centres.iter().map(|(_, c)| *c).collect();
    // The mean's line is of (x - middle) scale, the polynomial's of (x - shift) epsilon.
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

/// Lists kernels, each by its place as the kernel measures it and its coefficient, that make the covariance with a
/// functional, times `c`.
///
/// - `place`: shifts a place and scales it by `epsilon`, as the runtime does.
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

/// Counts the quadratures of a box, as the kernel measures it.
fn pieces([from, to]: [f64; 2]) -> f64 {
    ((to - from) / PIECE).ceil()
}
