//! The bounds of SciPy's own tests of `RBFInterpolator`, for all samples and for 20 neighbours,
//! applied to our interpolator; and SciPy's results, computed by SciPy 1.17.1.

use crate::kernel::common::{
    apart, franke, franke_at, halton, json, matrix as read_matrix, random, rows, wahba_at,
};
use faer::Mat;
use faer::linalg::solvers::SolveLstsq;
use sinew_runtime::kernel::Kernel;
use sinew_trainer::ErrorKind;
use sinew_trainer::regression::function::order;
use sinew_trainer::scattered::compat::scipy::{RbfInterpolator, ScipyOptions};
use sinew_trainer::scattered::problem::Smoothing;
use sinew_trainer::scattered::solver::matrix::matrix;
use sinew_trainer::scattered::solver::options::wendland;
use sinew_trainer::scattered::solver::system::System;
use sinew_trainer::scattered::sum::{monomials, powers};

const INVARIANT: [&str; 4] = ["linear", "thin_plate_spline", "cubic", "quintic"];
const OTHERS: [&str; 4] = ["multiquadric", "inverse_multiquadric", "inverse_quadratic", "gaussian"];
/// All samples, 20 neighbours, as many neighbours as samples.
const NEIGHBOURS: [Option<usize>; 3] = [None, Some(20), Some(usize::MAX)];

fn all() -> impl Iterator<Item = &'static str> {
    INVARIANT.into_iter().chain(OTHERS)
}

fn options(kernel: &str, epsilon: Option<f64>, neighbors: Option<usize>) -> ScipyOptions {
    ScipyOptions { kernel: Some(kernel.into()), epsilon, neighbors, ..ScipyOptions::default() }
}

fn at(sites: &Mat<f64>, values: &Mat<f64>, options: &ScipyOptions, queries: &Mat<f64>) -> Mat<f64> {
    let function = RbfInterpolator::new(sites, values, options).unwrap();
    let found: Vec<Vec<f64>> =
        rows(queries).iter().map(|x| function.evaluate(x).unwrap().0).collect();
    Mat::from_fn(found.len(), values.ncols(), |i, o| found[i][o])
}

/// Evaluates the monomials up to a degree, n x T.
fn monomials_at(points: &Mat<f64>, degree: usize) -> Mat<f64> {
    let terms = monomials(points.ncols(), degree);
    let values: Vec<Vec<f64>> = rows(points).iter().map(|x| powers(&terms, x)).collect();
    Mat::from_fn(values.len(), terms.len(), |i, t| values[i][t])
}

fn scaled(points: &Mat<f64>, scale: f64, shift: f64) -> Mat<f64> {
    Mat::from_fn(points.nrows(), points.ncols(), |i, c| points[(i, c)] * scale + shift)
}

/// Returns `n` samples of Wahba's function on 0 to 3, and queries between them.
fn line(n: usize) -> (Mat<f64>, Mat<f64>) {
    (scaled(&halton(0, n, 1), 3.0, 0.0), scaled(&halton(n, 50, 1), 3.0, 0.0))
}

/// Returns 100 points of the unit square, and 100 other points.
fn square() -> (Mat<f64>, Mat<f64>) {
    (halton(0, 100, 2), halton(100, 100, 2))
}

#[test]
fn kernels_are_definite_where_polynomials_reach_their_order() {
    for d in 1..=5 {
        let wendland = wendland(d).unwrap();
        let own = |kernel: &Kernel| !matches!(kernel, Kernel::Wendland { .. } | Kernel::Hat { .. });
        for kernel in Kernel::ALL.into_iter().filter(own).chain([wendland]) {
            for round in 0..100 {
                let points = scaled(&halton(10 * round, 10, d), 2.0, -1.0);
                let k = matrix(kernel, &points, &points);
                let p = match order(kernel).unwrap() {
                    0 => Mat::zeros(10, 0),
                    order => monomials_at(&points, order - 1),
                };
                // In 5 inputs, degree 2 has more monomials than there are points.
                if p.ncols() < 10 {
                    let definite = System::new(&k, &p).whitened(&Mat::zeros(10, 1)).is_some();
                    assert!(definite, "{kernel:?} {d} {round}");
                }
            }
        }
    }
}

#[test]
fn epsilon_changes_nothing_where_it_need_not_be_given() {
    for kernel in INVARIANT {
        for neighbours in NEIGHBOURS {
            let (x, queries) = line(50);
            let of = |epsilon| {
                at(&x, &wahba_at(&x), &options(kernel, Some(epsilon), neighbours), &queries)
            };
            assert!(apart(&of(1.0), &of(2.0)) < 1e-8, "{kernel}");
            let (x, queries) = square();
            let of = |epsilon| {
                at(&x, &franke_at(&x), &options(kernel, Some(epsilon), neighbours), &queries)
            };
            assert!(apart(&of(1.0), &of(2.0)) < 1e-8, "{kernel}");
        }
    }
}

#[test]
fn domains_may_be_vast_and_far_away() {
    let (x, queries) = square();
    let y = franke_at(&x);
    let (scale, shift) = (1e50, 1e55);
    for neighbours in NEIGHBOURS {
        for kernel in all() {
            let epsilon = OTHERS.contains(&kernel).then_some(5.0);
            let near = at(&x, &y, &options(kernel, epsilon, neighbours), &queries);
            let vast = options(kernel, epsilon.map(|e| e / scale), neighbours);
            let (x, queries) = (scaled(&x, scale, shift), scaled(&queries, scale, shift));
            let found = apart(&near, &at(&x, &y, &vast, &queries));
            assert!(found < 1e-8, "{kernel} {neighbours:?} {found:.1e}");
        }
    }
}

#[test]
fn polynomials_of_the_degree_are_reproduced() {
    for neighbours in NEIGHBOURS {
        // SciPy evaluates 1,033 queries in several chunks.
        let (x, queries) = (halton(0, 50, 2), halton(50, 1033, 2));
        let coefficients = random(0, 10, 1);
        let y = monomials_at(&x, 3) * &coefficients;
        let options =
            ScipyOptions { degree: Some(3), neighbors: neighbours, ..ScipyOptions::default() };
        let found = at(&x, &y, &options, &queries);
        assert!(apart(&found, &(monomials_at(&queries, 3) * coefficients)) < 1e-8);
    }
}

#[test]
fn several_values_are_each_alone() {
    // Complex values are two columns.
    let (x, queries) = square();
    let y = Mat::from_fn(100, 2, |i, o| franke(x[(i, o)], x[(i, 1 - o)]));
    for neighbours in NEIGHBOURS {
        let options = options("thin_plate_spline", None, neighbours);
        let both = at(&x, &y, &options, &queries);
        for o in 0..2 {
            let alone = at(&x, &y.subcols(o, 1).to_owned(), &options, &queries);
            assert!(apart(&both.subcols(o, 1).to_owned(), &alone) < 1e-12);
        }
    }
}

#[test]
fn functions_are_found_between_their_samples() {
    let mean_square = |a: &Mat<f64>, b: &Mat<f64>| (a - b).squared_norm_l2() / a.nrows() as f64;
    for kernel in all() {
        for neighbours in NEIGHBOURS {
            let options = options(kernel, Some(5.0), neighbours);
            let (x, queries) = line(50);
            let found = at(&x, &wahba_at(&x), &options, &queries);
            assert!(mean_square(&found, &wahba_at(&queries)) < 1e-4, "{kernel} {neighbours:?}");
            let (x, queries) = square();
            let found = at(&x, &franke_at(&x), &options, &queries);
            assert!(mean_square(&found, &franke_at(&queries)) < 2e-4, "{kernel} {neighbours:?}");
        }
    }
}

#[test]
fn some_smoothing_removes_noise() {
    let x = line(100).0;
    let truth = wahba_at(&x);
    // A sum of twelve uniform numbers is almost normal.
    let uniform = random(1, 100, 12);
    let y = Mat::from_fn(100, 1, |i, _| truth[(i, 0)] + 0.2 * uniform.row(i).sum() / 2.0);
    assert!((&y - &truth).norm_l2() / 10.0 > 0.15, "there is noise to remove");
    for kernel in all() {
        for neighbours in NEIGHBOURS {
            let rms = |k: u32| {
                let lambda = 10f64.powf(-4.0 + 5.0 * f64::from(k) / 19.0);
                let smoothing = Some(Smoothing::Given(lambda));
                let options = ScipyOptions { smoothing, ..options(kernel, Some(1.0), neighbours) };
                (at(&x, &y, &options, &x) - &truth).norm_l2() / 10.0
            };
            assert!((0..20).any(|k| rms(k) < 0.1), "{kernel} {neighbours:?}");
        }
    }
}

#[test]
fn an_outlier_can_be_smoothed_alone() {
    let x = halton(0, 50, 1);
    let y = monomials_at(&x, 2) * random(2, 3, 1);
    let mut spoilt = y.clone();
    spoilt[(10, 0)] += 1.0;
    let mut lambda = vec![0.0; 50];
    lambda[10] = 1000.0;
    for neighbors in NEIGHBOURS {
        let smoothing = Some(Smoothing::Each(lambda.clone()));
        let options = ScipyOptions { smoothing, neighbors, ..ScipyOptions::default() };
        assert!(apart(&at(&x, &spoilt, &options, &x), &y) < 1e-4);
    }
}

#[test]
fn much_smoothing_leaves_the_least_squares_polynomial() {
    let smoothing = Some(Smoothing::Given(1e8));
    for neighbors in [None, Some(usize::MAX)] {
        let options = ScipyOptions {
            smoothing: smoothing.clone(),
            degree: Some(3),
            neighbors,
            ..ScipyOptions::default()
        };
        let check = |x: &Mat<f64>, y: &Mat<f64>, queries: &Mat<f64>| {
            let coefficients = monomials_at(x, 3).qr().solve_lstsq(y);
            let expected = monomials_at(queries, 3) * coefficients;
            assert!(apart(&at(x, y, &options, queries), &expected) < 1e-8);
        };
        let (x, queries) = line(50);
        check(&x, &wahba_at(&x), &queries);
        let (x, queries) = square();
        check(&x, &franke_at(&x), &queries);
    }
}

#[test]
fn neighbours_make_the_function_of_themselves_alone() {
    let (x, queries) = square();
    let y = franke_at(&x);
    let found = at(&x, &y, &options("thin_plate_spline", None, Some(20)), &queries);
    for (q, query) in rows(&queries).iter().enumerate() {
        let far = |i: &usize| (x[(*i, 0)] - query[0]).hypot(x[(*i, 1)] - query[1]);
        let mut near: Vec<usize> = (0..100).collect();
        near.sort_by(|a, b| far(a).total_cmp(&far(b)));
        let own = |m: &Mat<f64>| Mat::from_fn(20, m.ncols(), |i, c| m[(near[i], c)]);
        let one = queries.subrows(q, 1).to_owned();
        let alone = at(&own(&x), &own(&y), &options("thin_plate_spline", None, None), &one);
        assert!((alone[(0, 0)] - found[(q, 0)]).abs() < 1e-8);
    }
}

#[test]
fn one_sample_is_a_constant() {
    for d in 1..=3 {
        for neighbours in NEIGHBOURS {
            let x = Mat::zeros(1, d);
            let y = Mat::from_fn(1, 1, |_, _| 1.0);
            assert_eq!(at(&x, &y, &options("linear", None, neighbours), &x), y);
        }
    }
}

/// Returns five samples on a line.
fn five() -> (Mat<f64>, Mat<f64>) {
    (Mat::from_fn(5, 1, |i, _| 0.25 * i as f64), Mat::zeros(5, 1))
}

#[test]
fn arguments_that_do_not_fit_are_errors() {
    let (x, y) = five();
    let default = ScipyOptions::default();
    let refused = |x: &Mat<f64>, y: &Mat<f64>, options: &ScipyOptions| {
        RbfInterpolator::new(x, y, options).unwrap_err()
    };
    let flat = RbfInterpolator::new(&x, &y, &default).unwrap();
    let query = flat.evaluate(&[0.0, 0.0]).unwrap_err();
    assert_eq!(query.message(), "expected a query of 1 numbers, found 2");
    let rows = refused(&x, &Mat::zeros(1, 1), &default);
    assert_eq!(rows.message(), "expected a row of values for each of 5 sites, found 1");
    let one = ScipyOptions { smoothing: Some(Smoothing::Each(vec![1.0])), ..default.clone() };
    assert_eq!(refused(&x, &y, &one).message(), "expected one smoothing or 5, found 1");
    let unknown = refused(&x, &y, &options("test", None, None));
    let expected = "\"test\" is no kernel of SciPy's: expected one of linear, ";
    assert!(unknown.message().starts_with(expected), "{unknown}");
    for kernel in OTHERS {
        let error = refused(&x, &y, &options(kernel, None, None));
        assert_eq!(error.kind(), ErrorKind::Missing);
        assert!(error.message().ends_with(" needs an epsilon"), "{error}");
    }
    let needed = "degree 1 in 1 inputs needs 2 samples, found 1";
    assert_eq!(refused(&Mat::zeros(1, 1), &Mat::zeros(1, 1), &default).message(), needed);
    assert_eq!(refused(&x, &y, &options("cubic", None, Some(1))).message(), needed);
    let low = ScipyOptions { degree: Some(-2), ..default.clone() };
    assert_eq!(refused(&x, &y, &low).message(), "degree is -2, expected -1 or more");
    let zero = refused(&x, &y, &options("cubic", Some(0.0), None));
    assert_eq!(zero.message(), "epsilon is 0, expected a finite number other than 0");
    let none = refused(&x, &y, &options("cubic", None, Some(0)));
    assert_eq!(none.message(), "neighbors is 0, expected at least 1");
}

#[test]
fn a_degree_below_the_kernels_least_is_warned_of_and_none_is_not() {
    let (x, y) = five();
    for (kernel, least) in
        [("multiquadric", 0), ("linear", 0), ("thin_plate_spline", 1), ("cubic", 1), ("quintic", 2)]
    {
        let of = |degree: i32| {
            let options = ScipyOptions { degree: Some(degree), ..options(kernel, Some(1.0), None) };
            RbfInterpolator::new(&x, &y, &options).unwrap().warnings
        };
        let conditions = |w: &String| w.starts_with("the fit is ill-conditioned ");
        assert!(of(-1).iter().all(conditions), "{kernel}");
        assert!(of(least).iter().all(conditions), "{kernel}");
        if least > 0 {
            let degree = least - 1;
            let warning = format!(
                "the degree {degree} is below the kernel's least, {least}: the function may not be unique"
            );
            assert!(of(degree).contains(&warning), "{kernel}");
        }
    }
}

#[test]
fn samples_on_a_line_of_the_plane_are_singular() {
    let x = Mat::from_fn(3, 2, |i, c| if c == 0 { i as f64 } else { 0.0 });
    for neighbours in [None, Some(usize::MAX)] {
        let made = RbfInterpolator::new(
            &x,
            &Mat::zeros(3, 1),
            &options("thin_plate_spline", None, neighbours),
        );
        let refused = match made {
            Ok(function) => function.evaluate(&[0.0, 0.0]).unwrap_err(),
            Err(refused) => refused,
        };
        assert_eq!(refused.kind(), ErrorKind::Fit);
        let singular = "the system is singular: the samples determine 2 of 3 monomials";
        assert_eq!(refused.message(), singular);
    }
}

/// Tolerance relative to the range of the expected values (METHOD §2.7).
const TOLERANCE: f64 = 1e-9;

#[test]
fn every_case_is_scipys_to_a_billionth_of_its_range() {
    let Some(file) = json("rbf-scipy/rbf_reference.json") else { return };
    let cases = file["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 23);
    for case in cases {
        let options: ScipyOptions = serde_json::from_value(case["options"].clone()).unwrap();
        let [sites, values, queries, expected] =
            ["sites", "values", "queries", "expected"].map(|name| read_matrix(&case[name]));
        let found = RbfInterpolator::new(&sites, &values, &options).unwrap();
        let found = evaluate(&found, &queries);
        let all = || rows(&expected).concat().into_iter();
        let range = all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min);
        let share = apart(&found, &expected) / range;
        println!("{}: {share:.1e}", case["name"]);
        assert!(share <= TOLERANCE, "{}: {share:.1e}", case["name"]);
    }
}

/// Evaluates a function at queries, q x m.
fn evaluate(function: &RbfInterpolator, queries: &Mat<f64>) -> Mat<f64> {
    let all: Vec<Vec<f64>> =
        rows(queries).iter().map(|x| function.evaluate(x).unwrap().0).collect();
    Mat::from_fn(all.len(), all[0].len(), |i, o| all[i][o])
}

#[test]
fn the_posts_table_is_scipys() {
    let Some(file) = json("../reference/seed002_reference.json") else { return };
    let [sites, values, grid] =
        ["samples", "outputs", "grid_points"].map(|n| read_matrix(&file[n]));
    let cases = file["scipy_rbfinterpolator"].as_array().unwrap();
    assert_eq!(cases.len(), 16);
    for case in cases {
        let options = ScipyOptions {
            kernel: case["kernel"].as_str().map(str::to_owned),
            epsilon: case["epsilon"].as_f64(),
            smoothing: serde_json::from_value(case["smoothing"].clone()).unwrap(),
            ..ScipyOptions::default()
        };
        let found = RbfInterpolator::new(&sites, &values, &options).unwrap();
        let kernels = case["coeffs"].as_array().unwrap()[..5].to_vec();
        let own =
            &found.whole.as_ref().unwrap().0.coefficients.subcols(0, 5).transpose().to_owned();
        assert!(apart(own, &read_matrix(&kernels.into())) < 1e-11, "{options:?}");
        assert!(apart(&evaluate(&found, &sites), &read_matrix(&case["at_samples"])) < 1e-11);
        assert!(
            apart(&evaluate(&found, &grid), &read_matrix(&case["grid"])) < 1e-11,
            "{options:?}"
        );
    }
    let quintic = ScipyOptions { kernel: Some("quintic".into()), ..ScipyOptions::default() };
    let refused = RbfInterpolator::new(&sites, &values, &quintic).unwrap_err().to_string();
    assert_eq!(refused, "degree 2 in 2 inputs needs 6 samples, found 5");
}
