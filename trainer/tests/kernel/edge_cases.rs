//! Data without a function, or without an obvious function: results of other libraries, and ours.

use crate::kernel::common::{apart, evaluate, franke_at, halton, json, matrix, numbers, samples};
use faer::{Mat, Side};
use serde_json::Value;
use sinew_runtime::kernel::Kernel;
use sinew_trainer::ErrorKind;
use sinew_trainer::scattered::compat::published::{Published, PublishedKernel, PublishedOptions};
use sinew_trainer::scattered::compat::scipy::{RbfInterpolator, ScipyOptions};
use sinew_trainer::scattered::problem::Smoothing;
use sinew_trainer::scattered::solver::fit::Fit;
use sinew_trainer::scattered::solver::matrix::matrix as kernels;
use sinew_trainer::scattered::solver::options::Options;
use sinew_trainer::scattered::solver::samples::{Conflicts, Samples};
use sinew_trainer::scattered::solver::scaling::{Block, Scaling};

fn file() -> Option<Value> {
    json("../reference/edge_cases.json")
}

fn column(of: &[f64]) -> Mat<f64> {
    Mat::from_fn(of.len(), 1, |i, _| of[i])
}

fn published(kernel: PublishedKernel, radius: f64) -> PublishedOptions {
    PublishedOptions {
        kernel,
        radius,
        regularization: 0.0,
        normalise_features: false,
        normalise_distances: kernel != PublishedKernel::Linear,
    }
}

#[test]
fn a_thin_plate_without_a_polynomial_vanishes_at_some_radius() {
    let Some(file) = file() else { return };
    let values = column(&[1.0, 2.0]);
    let two = column(&[0.0, 1.0]);
    let options = published(PublishedKernel::ThinPlate, 1.0 / 2f64.sqrt());
    let found = Published::new(&two, &values, &options).unwrap();
    let expected = &file["tps_two_points_radius_inv_sqrt2"]["at_samples"];
    assert!(apart(&evaluate(&found.sum, &two).transpose().to_owned(), &matrix(expected)) < 1e-12);
    // With a polynomial, the function interpolates.
    let ours = Fit::new(&samples(&two, &values), &Options::new(Kernel::ThinPlate)).unwrap();
    assert!(apart(&evaluate(&ours.sum, &two), &values) < 1e-14);
}

#[test]
fn an_equilateral_thin_plate_is_rounding_as_published_and_a_plane_with_its_polynomial() {
    let Some(file) = file() else { return };
    let triangle = Mat::from_fn(3, 2, |i, c| [[0.0, 0.0], [1.0, 0.0], [0.5, 0.75f64.sqrt()]][i][c]);
    let values = column(&[1.0, 2.0, 3.0]);
    let options = published(PublishedKernel::ThinPlate, (1.0f64 / 6.0).sqrt());
    let found = Published::new(&triangle, &values, &options).unwrap();
    let missed = apart(&evaluate(&found.sum, &triangle), &values);
    assert!(missed > 0.4, "what is left of the matrix is rounding: {missed}");
    let expected = matrix(&file["tps_equilateral_radius_inv_sqrt6"]["at_samples"]);
    assert!(apart(&expected.transpose().to_owned(), &values) > 0.4);
    let scipy = RbfInterpolator::new(&triangle, &values, &ScipyOptions::default()).unwrap();
    let expected = matrix(&file["tps_equilateral_scipy"]["at_samples"]);
    assert!(apart(&evaluate(&scipy.whole.as_ref().unwrap().0, &triangle), &expected) < 1e-12);
}

/// Returns the post's samples, with a sixth sample at the first site and another value.
fn conflicting() -> (Mat<f64>, Mat<f64>) {
    let sites = [[0.0, 0.0], [2.0, 3.0], [3.0, -1.0], [-4.0, -2.0], [-2.0, 3.0], [0.0, 0.0]];
    (Mat::from_fn(6, 2, |i, c| sites[i][c]), column(&[3.0, 0.5, 1.0, -1.0, 1.0, 5.0]))
}

#[test]
fn conflicting_repetitions_are_averaged_as_published_and_refused_by_name_here() {
    let Some(file) = file() else { return };
    let (sites, values) = conflicting();
    for (name, kernel, tolerance) in [
        ("linear", PublishedKernel::Linear, 1e-9),
        ("gaussian", PublishedKernel::Gaussian, 1e-6),
        ("wendland", PublishedKernel::BeckertWendlandC2, 1e-9),
    ] {
        let found = Published::new(&sites, &values, &published(kernel, 1.0)).unwrap();
        let expected = column(&numbers(&file["duplicate_conflicting"][name]));
        assert!(apart(&evaluate(&found.sum, &sites), &expected) < tolerance, "{name}");
    }
    let blocks = [Block { len: 2, weight: 1.0 }];
    let refused = Samples::new(&sites, &values, &blocks, Conflicts::Refuse).unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::Mismatch);
    assert_eq!(refused.message(), "rows 0 and 5 have the same site and different values");
    let averaged = Samples::new(&sites, &values, &blocks, Conflicts::Average).unwrap();
    let fit = Fit::new(&averaged, &Options::new(Kernel::Gaussian)).unwrap();
    assert!((fit.sum.evaluate(&[0.0, 0.0])[0] - 4.0).abs() < 1e-12);
}

#[test]
fn repetitions_are_singular_by_scipys_rules_until_they_are_smoothed() {
    let Some(file) = file() else { return };
    assert_eq!(file["duplicate_scipy"], "LinAlgError: Singular matrix.");
    let (sites, values) = conflicting();
    let mut options = ScipyOptions::default();
    let refused = RbfInterpolator::new(&sites, &values, &options).unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::Fit);
    assert_eq!(refused.message(), "the system is singular: rows 0 and 5 have the same site");
    options.smoothing = Some(Smoothing::Given(1e-9));
    let found = RbfInterpolator::new(&sites, &values, &options).unwrap();
    let expected = column(&numbers(&file["duplicate_scipy_smoothing_1e-9"]));
    // The published coefficients are 1e9, so rounding is 1e-6 in both; our function takes the mean
    // of the pair.
    let found = evaluate(&found.whole.as_ref().unwrap().0, &sites);
    assert!(apart(&found, &expected) < 1e-5);
    assert!((found[(0, 0)] - 4.0).abs() < 1e-5 && (found[(5, 0)] - 4.0).abs() < 1e-5);
}

/// Returns the message about two samples whose distance, or its function, is not finite.
fn not_finite(row: usize, column: usize) -> String {
    format!("the distance or its function between samples {row} and {column} is not finite")
}

#[test]
fn a_radius_of_zero_is_guarded_as_in_the_posts_own_language() {
    let Some(file) = file() else { return };
    // The published Python divides by zero, except for the multiquadric, which then equals the
    // distance.
    let (sites, values) = conflicting();
    let (sites, values) = (sites.subrows(0, 5).to_owned(), values.subrows(0, 5).to_owned());
    let solve = |kernel| Published::new(&sites, &values, &published(kernel, 0.0));
    let theta = solve(PublishedKernel::MultiQuadraticBiharmonic).unwrap().theta;
    let expected = matrix(&file["zero_radius"]["mq"]);
    assert!(apart(&theta, &expected) < 1e-9 * expected.norm_max());
    for (name, kernel) in
        [("gaussian", PublishedKernel::Gaussian), ("wendland", PublishedKernel::BeckertWendlandC2)]
    {
        assert!(file["zero_radius"][name].is_string());
        let found = solve(kernel).unwrap();
        assert!(apart(&evaluate(&found.sum, &sites), &values) < 1e-9, "isolated by the guard");
    }
    let singular = solve(PublishedKernel::InverseMultiQuadraticBiharmonic).unwrap_err();
    assert_eq!(singular.message(), not_finite(0, 0));
    let zero = Options { epsilon: f64::INFINITY, ..Options::new(Kernel::Gaussian) };
    let error = zero.check().unwrap_err();
    assert_eq!(error.message(), "epsilon is inf, expected a finite number above 0");
}

#[test]
fn a_single_sample_has_no_norm_as_published_and_is_a_constant_here() {
    let Some(file) = file() else { return };
    assert!(file["single_sample"]["gaussian"].is_string());
    let (site, value) = (Mat::from_fn(1, 2, |_, _| 1.5), column(&[7.0]));
    let options = published(PublishedKernel::Gaussian, 1.0);
    let refused = Published::new(&site, &value, &options).unwrap_err();
    assert_eq!(refused.message(), not_finite(0, 0));
    for kernel in Kernel::ALL.into_iter().filter(|k| !matches!(k, Kernel::Hat { .. })) {
        let fit = Fit::new(&samples(&site, &value), &Options::new(kernel)).unwrap();
        assert_eq!(fit.sum.evaluate(&[-40.0, 3.0]), [7.0], "{kernel:?}");
    }
}

#[test]
fn nans_are_errors_with_their_place() {
    let Some(file) = file() else { return };
    assert!(file["nan_feature"].is_string());
    let (mut sites, values) = conflicting();
    sites[(3, 1)] = f64::NAN;
    let refused = Published::new(&sites, &values, &published(PublishedKernel::Linear, 1.0));
    assert_eq!(refused.unwrap_err().message(), not_finite(3, 0));
    let place = "the site of row 3, column 1 is not finite";
    let blocks = [Block { len: 2, weight: 1.0 }];
    let refused = Samples::new(&sites, &values, &blocks, Conflicts::Refuse).unwrap_err();
    assert_eq!(refused.message(), place);
    let refused = RbfInterpolator::new(&sites, &values, &ScipyOptions::default()).unwrap_err();
    assert_eq!(refused.message(), place);
}

#[test]
fn distances_are_blind_to_origins_and_to_the_number_of_samples() {
    let Some(file) = file() else { return };
    // As published, a column shifted by 1000 loses its whole spread.
    let spreads = |name: &str| numbers(&file["feature_norm_translation"][name]);
    assert!(spreads("spread_after_shifted")[1] < 1e-5 * spreads("spread_after_original")[1]);
    let blocks = [Block { len: 1, weight: 1.0 }; 2];
    let near = halton(0, 20, 2);
    let far = Mat::from_fn(20, 2, |i, c| near[(i, c)] + 1000.0);
    let of = |sites: &Mat<f64>| Scaling::new(sites, &blocks).unwrap().apply(sites);
    // Each shift is rounded to f32, which moves all sites equally.
    let from_first = |of: Mat<f64>| Mat::from_fn(20, 2, |i, c| of[(i, c)] - of[(0, c)]);
    assert!(apart(&from_first(of(&near)), &from_first(of(&far))) < 1e-11);
    // As published, distances shrink with n.
    let norms = file["frobenius_vs_n"].as_object().unwrap();
    let mean = |n: &str| norms[n]["mean_normalised"].as_f64().unwrap();
    assert!(mean("5") > 40.0 * mean("200"));
    for n in [5, 200] {
        let points = of(&halton(0, n, 2));
        let apart = |i: usize, k: usize| {
            (points[(i, 0)] - points[(k, 0)]).hypot(points[(i, 1)] - points[(k, 1)])
        };
        let pairs: Vec<f64> =
            (0..n).flat_map(|i| (0..i).map(move |k| (i, k))).map(|(i, k)| apart(i, k)).collect();
        assert!((pairs.iter().sum::<f64>() / pairs.len() as f64 - 1.0).abs() < 1e-12);
    }
}

#[test]
fn fits_that_rounding_decides_are_refused_with_the_remedy() {
    let Some(file) = file() else { return };
    let cases = file["solver_accuracy"].as_array().unwrap();
    let worst = cases.iter().filter(|case| case["cond"].as_f64().unwrap() > 1e13);
    assert!(worst.count() == 2, "20 and 40 samples at the post's default radius");
    let sites = halton(1, 40, 2);
    let samples = samples(&sites, &franke_at(&sites));
    let wide = Options { epsilon: 0.05, ..Options::new(Kernel::Gaussian) };
    let Err(refused) = Fit::new(&samples, &wide) else {
        panic!("a gaussian of 20 times the mean distance was fitted");
    };
    assert_eq!(refused.kind(), ErrorKind::Fit);
    let text = refused.to_string();
    for part in ["ill-conditioned", "smooth more", "narrower kernel", "fewer centres"] {
        assert!(text.contains(part), "{text}");
    }
    // A system may have an acceptable condition and still miss its samples.
    let flat = Options { degree: Some(2), ..Options::new(Kernel::Matern52) };
    let refused = Fit::new(&samples, &Options { epsilon: 0.05, ..flat }).err();
    let refused = refused.expect("samples are missed by more than is promised").to_string();
    let number = |before: &str, after: &str| -> f64 {
        let (_, rest) = refused.split_once(before).expect(before);
        rest.split_once(after).expect(after).0.parse().unwrap()
    };
    let rcond = number("the fit is ill-conditioned (reciprocal condition ", ",");
    let missed = number("samples missed by ", " of their range)");
    assert!(rcond > 1e-9 && missed > 1e-10, "{refused}");
    let mean = Fit::new(&samples, &Options { epsilon: 4.0, ..wide }).unwrap();
    assert!(apart(&evaluate(&mean.sum, &sites), &samples.values) < 1e-10);
    let smoothed = Fit::new(&samples, &Options { smoothing: 1e-3, ..wide }).unwrap();
    assert!(smoothed.rcond > 1e-8);
}

#[test]
fn wendlands_kernel_of_the_post_has_its_least_eigenvalue_on_a_cubes_corners() {
    let Some(file) = file() else { return };
    for d in [3, 6, 8] {
        let of = &file["wendland_c2_min_eig_by_dimension"][d.to_string()];
        let epsilon = 1.0 / of["radius"].as_f64().unwrap();
        let corners =
            Mat::from_fn(1 << d, d, |i, c| epsilon * f64::from(u8::from(i >> c & 1 == 1)));
        assert_eq!(of["points"], corners.nrows());
        let k = kernels(Kernel::Wendland { l: 3 }, &corners, &corners);
        let least = k.self_adjoint_eigenvalues(Side::Lower).unwrap()[0];
        assert!((least - of["min_eig"].as_f64().unwrap()).abs() < 1e-12);
    }
}
