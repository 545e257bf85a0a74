//! A function of observations as a part kernel, where the kernel library can express it.
//!
//! The covariance with a value is a kernel about its place. That with an average is an integral of kernels, whose
//! quadrature is a kernel at each node; that with a derivative is what a difference of eight kernels tends to. Both are
//! as good as f32 only where the kernel is smooth without end: the gaussian.

use super::covariance::Covariance;
use super::error::SignalError;
use super::functional::{Functional, nodes};
use super::kriging::Kriging;
use super::observations::Observations;
use crate::kernel::bound::{largest, rounded};
use crate::kernel::fade::Fade;
use crate::kernel::model::{Figures, Input, InputKind, KernelModel, Output, OutputKind};
use crate::kernel::sum::{KernelSum, Term};
use crate::numeric::columns::ends;
use faer::Mat;
use sinew_runtime::kernel::{Normalise, QueryRule};

/// Half a central difference of order 8, by steps from the middle.
const DIFFERENCE: [f64; 4] = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
/// Its step in lengths: what it leaves out is 4e-8 of a derivative, what f32 rounds 1e-6.
const STEP: f64 = 0.1;
/// Longest box that one quadrature is taken of, in lengths.
const PIECE: f64 = 2.0;

/// Makes a function with its names of what a fit found.
///
/// # Errors
/// [`SignalError::NoKernel`] of a covariance that is no kernel, and of derivatives and averages of one that is not the
/// gaussian.
pub fn function(observations: &Observations, fit: &Kriging) -> Result<KernelModel, SignalError> {
    let Observations { name, process, functionals, values, .. } = observations;
    let refused = |what: String| SignalError::NoKernel {
        what,
        can: "values with covariance squared exponential, ornstein-uhlenbeck, matern 3/2 or matern 5/2, and \
              derivatives and averages with squared exponential",
    };
    let Some((kernel, epsilon)) = process.covariance.kernel() else {
        return Err(refused(format!("covariance {}", process.covariance.name())));
    };
    let smooth = matches!(process.covariance, Covariance::SquaredExponential { .. });
    if let Some(at) =
        functionals.iter().position(|of| !smooth && !matches!(of, Functional::Value { .. }))
    {
        let name = process.covariance.name();
        return Err(refused(format!(
            "observation {at}, which is no value, with covariance {name}"
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
    let sum = rounded(&KernelSum {
        kernel,
        shift: vec![shift],
        scale: vec![epsilon],
        metric: None,
        centres: Mat::from_fn(1, centres.len(), |_, k| (centres[k].0 - shift) * epsilon),
        terms: basis[..terms.len()].to_vec(),
        coefficients: Mat::from_fn(1, numbers.len(), |_, k| numbers[k]),
    });
    let places: Vec<f64> = functionals.iter().map(Functional::middle).collect();
    let sites = Mat::from_fn(places.len(), 1, |i, _| places[i]);
    let misses = functionals.iter().zip(values).map(|(of, y)| (fit.predict(of).value - y).powi(2));
    let figures = Figures {
        residual_rms: (misses.sum::<f64>() / values.len() as f64).sqrt(),
        left_out_rms: 0.0,
        bound: largest(&sum, &sites).into_iter().fold(0.0, f64::max),
        rcond: 0.0,
    };
    let [low, high] = [f32::MIN, f32::MAX].map(f64::from);
    let free = OutputKind::Scalar { low, high, normalised: false, neutral: 0.0 };
    Ok(KernelModel {
        name: name.clone(),
        inputs: vec![Input { name: "x".to_owned(), kind: InputKind::Scalar, weight: 1.0 }],
        outputs: vec![Output { name: "value".to_owned(), kind: free }],
        sum,
        ranges: vec![ends(&places)],
        query: QueryRule::Free,
        fade: Fade { start: 0.0, end: 0.0 },
        normalise: Normalise::Never,
        variance: None,
        fit: figures,
    })
}

/// Lists kernels, each by its place and its coefficient, that make the covariance with a functional, so many times.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mixed_observations_become_kernels() {
        let text = br#"{"covariance": "squared exponential:1.5", "mean": "linear", "observations": [
            {"at": 0, "value": 1}, {"at": 1.5, "derivative": -2}, {"from": 3, "to": 9, "average": 0.5},
            {"at": 5, "value": 2}, {"at": 8, "value": 1}]}"#;
        let observations = Observations::parse(text, "f").unwrap();
        let fit = observations.fit().unwrap();
        let model = function(&observations, &fit).unwrap();
        for step in -10..=100 {
            let x = 0.1 * f64::from(step);
            let found = model.evaluate(&[x]).unwrap().numbers[0];
            let expected = fit.predict(&Functional::Value { at: x }).value;
            // Coefficients are rounded to f32.
            assert!((found - expected).abs() < 1e-5, "{x}: {found} {expected}");
        }
        assert!(model.fit.bound < 1e-3 && model.fit.residual_rms < 1e-9);
    }

    #[test]
    fn what_no_kernel_is_says_what_can() {
        let refused = |covariance: &str, rest: &str| {
            let text = format!(
                "{{\"covariance\": \"{covariance}\", \"observations\": [{{\"at\": 0, \"value\": 1}}{rest}]}}"
            );
            let observations = Observations::parse(text.as_bytes(), "f").unwrap();
            let fit = observations.fit().unwrap();
            function(&observations, &fit).map(|_| ()).map_err(|error| error.to_string())
        };
        let error = refused("oscillating:3,2", "").unwrap_err();
        assert!(
            error.starts_with("no part kernel holds covariance oscillating: it can hold values"),
            "{error}"
        );
        let error = refused("matern 5/2:1", ", {\"at\": 1, \"derivative\": 1}").unwrap_err();
        assert!(error.contains("observation 1, which is no value"), "{error}");
        assert!(refused("matern 5/2:1", ", {\"at\": 1, \"value\": 1}").is_ok());
    }
}
