//! A function of observations as a sum of kernels, where the kernel library can express it.
//!
//! The covariance with a value is a kernel about its place. That with an average is an integral of kernels, whose
//! quadrature is a kernel at each node. That with a derivative is the limit of a difference of eight kernels. Both are
//! as good as f32 only where the kernel is smooth without end: the gaussian.

use super::covariance::Covariance;
use super::error::{SignalError, check_positive};
use super::functional::{Functional, nodes};
use super::kriging::{Kriging, Process};
use crate::kernel::bound::rounded;
use crate::kernel::deviation::Probe;
use crate::kernel::model::{Input, InputKind};
use crate::kernel::scattered::samples::ranges;
use crate::kernel::sum::{KernelSum, Term};
use faer::Mat;

/// Half a central difference of order 8, by steps from the middle.
const DIFFERENCE: [f64; 4] = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
/// Its step in lengths: it is off by 4e-8 of a derivative, and f32 rounds 1e-6.
const STEP: f64 = 0.1;
/// Longest box that one quadrature is taken of, in lengths.
const PIECE: f64 = 2.0;

/// Makes the kernels of a fit, rounded to f32.
///
/// - `numbers`: the number of each observation as it is written, n.
///
/// # Errors
/// [`SignalError::NoKernel`] of a covariance that is no kernel, and of derivatives and averages of one that is not the
/// gaussian.
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
    let (kernels, terms, [shift, scale]) = fit.coefficients();
    let length = 0.5f64.sqrt() / epsilon;
    let centres: Vec<(f64, f64)> =
        functionals.iter().zip(kernels).flat_map(|(of, c)| centres(of, c, length)).collect();
    // The mean's line is of (x - shift) scale, the polynomial's of (x - shift) epsilon.
    let of_line = [1.0, scale / epsilon];
    let numbers = centres.iter().map(|(_, c)| *c);
    let numbers: Vec<f64> =
        numbers.chain(terms.iter().zip(of_line).map(|(b, share)| b * share)).collect();
    let basis = [Term::One, Term::Product { earlier: 0, input: 0 }];
    Ok(rounded(&KernelSum {
        kernel,
        shift: vec![shift],
        scale: vec![epsilon],
        metric: None,
        centres: Mat::from_fn(1, centres.len(), |_, k| (centres[k].0 - shift) * epsilon),
        terms: basis[..terms.len()].to_vec(),
        coefficients: Mat::from_fn(1, numbers.len(), |_, k| numbers[k]),
    }))
}

/// Returns the input of such a function.
pub fn input() -> Input {
    Input { name: "x".to_owned(), kind: InputKind::Scalar, weight: 1.0 }
}

/// Makes the queries at which the file of a fit is compared with it: where it was observed, and between.
///
/// - `limit`: the largest deviation of the file that is allowed, over the function's range. Where all is observed at one
///   place the range is the standard deviation of the process.
///
/// # Errors
/// [`SignalError::Number`] of a limit that is not above 0.
pub fn probe(functionals: &[Functional], fit: &Kriging, limit: f64) -> Result<Probe, SignalError> {
    check_positive("f32 error", limit)?;
    let ends = |of: &Functional| match *of {
        Functional::Value { at } | Functional::Derivative { at } => vec![at],
        Functional::Average { from, to } => vec![from, to],
    };
    let places: Vec<f64> = functionals.iter().flat_map(ends).collect();
    let value = |i: usize, _| fit.value(&Functional::Value { at: places[i] });
    let mut range = ranges(&Mat::from_fn(places.len(), 1, value));
    if places.iter().all(|place| *place == places[0]) {
        range[0] = range[0].max(fit.variance().sqrt());
    }
    let sites: Vec<Vec<f64>> = places.iter().map(|place| vec![*place]).collect();
    // Places that were fitted are finite.
    Probe::new(&[input()], &sites, range, limit).map_err(|_| SignalError::Empty)
}

/// Computes the value of a fit at its input, as [`Probe`] asks for it.
pub fn exact(fit: &Kriging) -> impl Fn(&[f64]) -> Vec<f64> + Sync {
    |x| x.iter().map(|at| fit.value(&Functional::Value { at: *at })).collect()
}

/// Lists kernels, each by its place and its coefficient, that make the covariance with a functional, times `c`.
fn centres(of: &Functional, c: f64, length: f64) -> Vec<(f64, f64)> {
    match *of {
        Functional::Value { at } => vec![(at, c)],
        Functional::Derivative { at } => {
            let step = STEP * length;
            let both = |(k, share): (usize, &f64)| {
                let off = (k + 1) as f64 * step;
                [(at + off, c * share / step), (at - off, -c * share / step)]
            };
            DIFFERENCE.iter().enumerate().flat_map(both).collect()
        }
        Functional::Average { from, to } => {
            let pieces = ((to - from) / (PIECE * length)).ceil().max(1.0);
            let side = (to - from) / pieces;
            let piece = |k: usize| {
                let start = from + side * k as f64;
                nodes(start, start + side).map(move |(at, share)| (at, c * share / pieces))
            };
            (0..pieces as usize).flat_map(piece).collect()
        }
    }
}
