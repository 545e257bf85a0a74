//! The numbers of `rkhs_reference.json`, except direct manipulation, which `tests/prior` checks.

use super::common::*;
use serde_json::Value;
use sinew_trainer::signal::covariance::Covariance;
use sinew_trainer::signal::functional::Functional;
use sinew_trainer::signal::kriging::Mean;
use sinew_trainer::signal::kriging::{Kriging, Process, gram};
use sinew_trainer::signal::table::{Table, autocovariance};
use std::path::Path;

fn reference() -> Option<Value> {
    let place = "../../shared/reference/rkhs_reference.json";
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(place);
    if !path.exists() {
        assert!(std::env::var_os("CI").is_none(), "{} must be there", path.display());
        eprintln!("no rkhs_reference.json: not tested");
        return None;
    }
    Some(serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap())
}

fn numbers(of: &Value) -> Vec<f64> {
    of.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn half(i: usize) -> Functional {
    Functional::Value { at: i as f64 + 0.5 }
}

/// Fits samples of the reference's Ornstein-Uhlenbeck process.
fn fitted(samples: &[f64], mean: Mean) -> Kriging {
    let places: Vec<f64> = (0..samples.len()).map(|i| i as f64).collect();
    let process = process(Covariance::OrnsteinUhlenbeck { length: 3.0 }, mean);
    Kriging::new(&process, &values(&places), samples).unwrap()
}

#[test]
fn ornstein_and_uhlenbeck_between_their_samples() {
    let Some(reference) = reference() else { return };
    let known = &reference["ou_markov_identity"];
    let samples = numbers(&known["samples"]);
    let fit = fitted(&samples, Mean::Zero);
    let expected = numbers(&known["at_half"]);
    assert_eq!(expected.len(), samples.len() - 1);
    // Left-out samples depend only on their neighbours, each with a ratio of hyperbolic sines.
    let l = known["ell"].as_f64().unwrap();
    let weight = (0.5 / l).sinh() / (1.0 / l).sinh();
    for (i, expected) in expected.iter().enumerate() {
        let found = fit.predict(&half(i));
        assert!((found.value - expected).abs() < 1e-10, "{i}");
        assert!((weight * (samples[i] + samples[i + 1]) - expected).abs() < 1e-10);
        let variance = 2.0 * (0.5 / l).sinh().powi(2) / (1.0 / l).sinh();
        assert!((found.variance - variance).abs() < 1e-10, "{}", found.variance);
    }
}

#[test]
fn an_offset_needs_a_mean_that_knows_of_it() {
    let Some(reference) = reference() else { return };
    let samples = numbers(&reference["ou_markov_identity"]["samples"]);
    let moved: Vec<f64> = samples.iter().map(|x| x + 100.0).collect();
    let at = half(5);
    let known = &reference["constant_offset_simple_kriging"];
    let simple = fitted(&moved, Mean::Zero).predict(&at).value - 100.0;
    assert!((simple - known["simple"].as_f64().unwrap()).abs() < 1e-9, "{simple}");
    let truth = fitted(&samples, Mean::Zero).predict(&at).value;
    assert!((truth - known["truth_zero_mean"].as_f64().unwrap()).abs() < 1e-9, "{truth}");
    let ordinary = fitted(&moved, Mean::Constant).predict(&at).value - 100.0;
    let expected = reference["constant_offset_ordinary_kriging"].as_f64().unwrap();
    assert!((ordinary - expected).abs() < 1e-9, "{ordinary}");
}

#[test]
fn errors_between_samples_are_as_large_as_the_variance_says_and_as_the_reference_found() {
    let Some(reference) = reference() else { return };
    // The reference writes exp(-(d/l)²).
    let families = [
        Covariance::SquaredExponential { length: 1.2 * 0.5f64.sqrt() },
        Covariance::OrnsteinUhlenbeck { length: 3.0 },
        Covariance::Oscillating { length: 4.0, period: 2.6 },
    ];
    for (covariance, row) in
        families.iter().zip(reference["superresolution_1d"].as_array().unwrap())
    {
        let coarse = 24;
        let places: Vec<f64> = (0..4 * coarse).map(|i| 0.25 * f64::from(i)).collect();
        let drawn = Drawn::new(covariance, &places);
        let at: Vec<f64> = (0..coarse).map(f64::from).collect();
        let process = process(covariance.clone(), Mean::Zero);
        let inside: Vec<usize> = (40..56).filter(|i| i % 4 != 0).collect();
        let fit = Kriging::new(&process, &values(&at), &vec![0.0; coarse as usize]).unwrap();
        let fine = |i: usize| Functional::Value { at: 0.25 * i as f64 };
        let weights: Vec<Vec<f64>> = inside.iter().map(|i| fit.weights(&fine(*i))).collect();
        let variances = inside.iter().map(|i| fit.predict(&fine(*i)).variance);
        let variance = variances.sum::<f64>() / inside.len() as f64;
        let (mut own, mut lines, mut splines) = (0.0, 0.0, 0.0);
        let mut numbers = Numbers::new(5);
        let runs = 6000;
        for _ in 0..runs {
            let truth = drawn.one(&mut numbers);
            let samples: Vec<f64> = truth.iter().step_by(4).copied().collect();
            for (i, weights) in inside.iter().zip(&weights) {
                let found: f64 = weights.iter().zip(&samples).map(|(w, x)| w * x).sum();
                let share = 0.25 * (i % 4) as f64;
                let line = samples[i / 4] * (1.0 - share) + samples[i / 4 + 1] * share;
                own += (found - truth[*i]).powi(2);
                lines += (line - truth[*i]).powi(2);
                splines += (spline(&samples, 0.25 * *i as f64) - truth[*i]).powi(2);
            }
        }
        let count = f64::from(runs) * inside.len() as f64;
        let [own, lines, splines] = [own, lines, splines].map(|sum| sum / count);
        let name = covariance.name();
        println!(
            "{name}: MSE {own:.5}, variance {variance:.5}, lines {lines:.5}, cubic spline {splines:.5}"
        );
        assert!((0.95..=1.05).contains(&(own / variance)), "{name}: {own} {variance}");
        for (key, found, within) in [
            ("kriging_variance", variance, 0.01),
            ("mse", own, 0.06),
            ("mse_linear", lines, 0.06),
            ("mse_cubic", splines, 0.06),
        ] {
            let expected = row[key].as_f64().unwrap();
            assert!((found / expected - 1.0).abs() < within, "{name}, {key}: {found} {expected}");
        }
        if matches!(covariance, Covariance::Oscillating { .. }) {
            assert!(splines > 2.0 * own, "{splines} {own}");
        }
    }
}

#[test]
fn estimated_covariances_are_definite() {
    let Some(reference) = reference() else { return };
    let known = &reference["empirical_autocovariance"];
    let trials = known["trials"].as_u64().unwrap();
    let covariance = Covariance::OrnsteinUhlenbeck { length: 3.0 };
    let places: Vec<f64> = (0..40).map(f64::from).collect();
    let drawn = Drawn::new(&covariance, &places);
    let mut numbers = Numbers::new(9);
    let indefinite = (0..trials).filter(|_| {
        let lags = autocovariance(&drawn.one(&mut numbers), 40);
        least(&faer::Mat::from_fn(40, 40, |i, k| lags[i.abs_diff(k)])) < -1e-12 * lags[0]
    });
    assert_eq!(indefinite.count() as u64, known["indefinite"]["biased"].as_u64().unwrap());
}

#[test]
fn indefinite_matrices_are_definite_after_clipping() {
    let covariance = Covariance::OrnsteinUhlenbeck { length: 3.0 };
    let places: Vec<f64> = (0..60).map(f64::from).collect();
    let samples = Drawn::new(&covariance, &places).one(&mut Numbers::new(3));
    // Sums divided by the number of their pairs are usually indefinite.
    let biased = autocovariance(&samples, 60).into_iter().enumerate();
    let lags: Vec<f64> = biased.map(|(lag, sum)| sum * 60.0 / (60 - lag) as f64).collect();
    let (table, clipped) = Table::new(&lags, 1.0).unwrap();
    assert!(clipped > 0.01, "{clipped}");
    let places: Vec<f64> = (0..90).map(|i| 0.61 * f64::from(i)).collect();
    let process = Process { covariance: Covariance::Table(table), mean: Mean::Zero, noise: 0.0 };
    assert!(least(&gram(&process, &values(&places))) > -1e-12);
}

/// Returns the smallest eigenvalue.
pub(crate) fn least(matrix: &faer::Mat<f64>) -> f64 {
    let values = matrix.self_adjoint_eigenvalues(faer::Side::Lower).unwrap();
    values.into_iter().fold(f64::INFINITY, f64::min)
}
