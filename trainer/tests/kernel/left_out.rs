//! Samples left out in closed form, against fits without them.

use crate::kernel::common::{franke_at, halton, random, samples};
use crate::kernel::reproduction::fitted;
use faer::Mat;
use sinew_runtime::kernel::Kernel;
use sinew_trainer::scattered::solver::fit::Fit;
use sinew_trainer::scattered::solver::leave_one_out::LeaveOneOut;
use sinew_trainer::scattered::solver::options::Options;
use sinew_trainer::scattered::solver::polynomial::{RANK_F64, Space};
use sinew_trainer::scattered::solver::system::solve;

const TOLERANCE: f64 = 1e-10;

/// Returns the rows of a matrix that are not in a group.
fn without(of: &Mat<f64>, group: &[usize]) -> Mat<f64> {
    let kept: Vec<usize> = (0..of.nrows()).filter(|i| !group.contains(i)).collect();
    Mat::from_fn(kept.len(), of.ncols(), |i, c| of[(kept[i], c)])
}

/// Returns the errors of a group under a fit to the other points.
fn brute(
    kernel: Kernel,
    points: &Mat<f64>,
    values: &Mat<f64>,
    lambda: &[f64],
    degree: Option<usize>,
    group: &[usize],
) -> Mat<f64> {
    let (own, y) = (without(points, group), without(values, group));
    let inputs: Vec<usize> = (0..points.ncols()).collect();
    let polynomial =
        Space { points: &own, inputs: &inputs, tolerance: RANK_F64 }.polynomial(degree);
    let kept: Vec<f64> =
        (0..lambda.len()).filter(|i| !group.contains(i)).map(|i| lambda[i]).collect();
    let solved = solve(kernel, &own, &kept, polynomial, &y);
    let sum = sinew_trainer::scattered::sum::KernelSum {
        kernel,
        shift: vec![0.0; points.ncols()],
        scale: vec![1.0; points.ncols()],
        metric: None,
        centres: own.transpose().to_owned(),
        terms: solved.polynomial.terms.clone(),
        coefficients: faer::concat![[solved.kernels.transpose(), solved.monomials.transpose()]],
    };
    let errors: Vec<Vec<f64>> = group
        .iter()
        .map(|&i| {
            let x: Vec<f64> = points.row(i).iter().copied().collect();
            let found = sum.evaluate(&x);
            (0..values.ncols()).map(|o| values[(i, o)] - found[o]).collect()
        })
        .collect();
    Mat::from_fn(group.len(), values.ncols(), |i, o| errors[i][o])
}

/// Returns sites in space, and sites on a plane in space, where polynomials are deficient.
fn sites() -> [Mat<f64>; 2] {
    let space = halton(1, 24, 3);
    let plane = Mat::from_fn(24, 3, |i, c| match c {
        2 => 0.3 * space[(i, 0)] - 0.8 * space[(i, 1)] + 0.1,
        c => space[(i, c)],
    });
    [space, plane]
}

#[test]
fn single_samples_and_groups_are_left_out_as_by_brute_force() {
    let groups: [&[usize]; 4] = [&[0], &[23], &[4, 5, 6, 7], &[1, 9, 14, 20, 22]];
    for (s, sites) in sites().iter().enumerate() {
        let values =
            Mat::from_fn(24, 2, |i, o| (3.0 * sites[(i, 0)] + o as f64).cos() + sites[(i, 1)]);
        for kernel in fitted(3) {
            let degree = Options::new(kernel).degree;
            for smoothing in [0.0, 1e-3] {
                let lambda: Vec<f64> = (0..24).map(|i| smoothing * (1.0 + i as f64)).collect();
                let points = sites * faer::Scale(2.0);
                let inputs = [0, 1, 2];
                let space = Space { points: &points, inputs: &inputs, tolerance: RANK_F64 };
                let polynomial = space.polynomial(degree);
                let deficient = polynomial.rank() < polynomial.terms.len();
                assert_eq!(deficient, s == 1 && degree > Some(0), "the plane's are");
                let solved = solve(kernel, &points, &lambda, polynomial, &values);
                let left_out = LeaveOneOut::of_solved(&solved, &lambda);
                for group in groups {
                    let found = left_out.errors(group).unwrap();
                    let expected = brute(kernel, &points, &values, &lambda, degree, group);
                    let missed = (found - &expected).norm_max();
                    assert!(
                        missed < TOLERANCE * (1.0 + expected.norm_max()),
                        "{kernel:?} {s} {group:?} {missed:.1e}"
                    );
                }
            }
        }
    }
}

#[test]
fn fits_are_left_out_as_they_are_made() {
    let sites = halton(1, 30, 2);
    let samples = samples(&sites, &franke_at(&sites));
    for kernel in [Kernel::Gaussian, Kernel::ThinPlate] {
        let options = Options { epsilon: 3.0, smoothing: 1e-4, ..Options::new(kernel) };
        let fit = Fit::new(&samples, &options).unwrap();
        let left_out = fit.leave_one_out();
        let points = fit.sum.centres.transpose().to_owned();
        let groups: Vec<Vec<usize>> = (0..6).map(|g| (5 * g..5 * g + 5).collect()).collect();
        let mut sum = 0.0;
        for group in &groups {
            let expected =
                brute(kernel, &points, &samples.values, &[1e-4; 30], options.degree, group);
            sum += expected.squared_norm_l2();
        }
        let found = left_out.mean_squares(&groups).unwrap()[0];
        assert!((found / (sum / 30.0) - 1.0).abs() < 1e-8, "{kernel:?}");
        let each = left_out.each();
        let third = brute(kernel, &points, &samples.values, &[1e-4; 30], options.degree, &[3]);
        assert!((each[3].unwrap() - third.norm_max()).abs() < TOLERANCE);
    }
}

#[test]
fn freedom_is_the_trace_of_the_smoother() {
    let sites = halton(1, 15, 2);
    for (kernel, smoothing) in
        [(Kernel::Gaussian, 0.1), (Kernel::ThinPlate, 0.02), (Kernel::Cubic, 0.0)]
    {
        let options = Options { smoothing, ..Options::new(kernel) };
        // Response at a sample to a value of 1 at this sample alone.
        let own = |i: usize| {
            let unit = Mat::from_fn(15, 1, |k, _| f64::from(u8::from(i == k)));
            let fit = Fit::new(&samples(&sites, &unit), &options).unwrap();
            let x: Vec<f64> = sites.row(i).iter().copied().collect();
            fit.sum.evaluate(&x)[0]
        };
        let expected: f64 = (0..15).map(own).sum();
        let fit = Fit::new(&samples(&sites, &franke_at(&sites)), &options).unwrap();
        assert!((fit.leave_one_out().freedom - expected).abs() < 1e-9, "{kernel:?}");
    }
}

#[test]
fn fewer_centres_are_left_out_as_by_brute_force() {
    let sites = halton(1, 30, 2);
    let values = Mat::from_fn(30, 2, |i, o| random(9, 30, 2)[(i, o)]);
    let samples = samples(&sites, &values);
    for (kernel, smoothing) in
        [(Kernel::Gaussian, 0.0), (Kernel::Gaussian, 1e-3), (Kernel::ThinPlate, 1e-3)]
    {
        let options = Options { smoothing, epsilon: 2.0, centres: Some(7), ..Options::new(kernel) };
        let fit = Fit::new(&samples, &options).unwrap();
        let is_centre = |i: &usize| {
            let x: Vec<f64> = sites.row(*i).iter().copied().collect();
            fit.sum.squared_distances(&fit.sum.scaled(&x)).any(|s| s < 1e-20)
        };
        let centre = (0..29).find(is_centre).unwrap();
        let left_out = fit.leave_one_out();
        // The columns, with λ n of all samples, without the rows of the group.
        let bases: Vec<Vec<f64>> = (0..30)
            .map(|i| {
                let x: Vec<f64> = sites.row(i).iter().copied().collect();
                let (g, p) = fit.sum.basis(&x);
                [g, p].concat()
            })
            .collect();
        let columns = bases[0].len();
        for group in [vec![0], vec![3, 4, 5, 6], vec![centre, 29]] {
            let a = Mat::from_fn(30, columns, |i, c| bases[i][c]);
            let kept = without(&a, &group);
            let ridge =
                Mat::<f64>::identity(columns, columns) * faer::Scale((30.0 * smoothing).sqrt());
            let stacked = faer::concat![[&kept], [&ridge]];
            let right =
                faer::concat![[&without(&values, &group)], [&Mat::<f64>::zeros(columns, 2)]];
            let solution = faer::linalg::solvers::SolveLstsq::solve_lstsq(&stacked.qr(), &right);
            let found = left_out.errors(&group).unwrap();
            for (row, &i) in group.iter().enumerate() {
                for o in 0..2 {
                    let predicted: f64 = (0..columns).map(|c| bases[i][c] * solution[(c, o)]).sum();
                    let expected = values[(i, o)] - predicted;
                    assert!(
                        (found[(row, o)] - expected).abs() < TOLERANCE * (1.0 + expected.abs()),
                        "{kernel:?}"
                    );
                }
            }
        }
        let trace: f64 = (0..30)
            .map(|i| 1.0 - 1.0 / (left_out.errors(&[i]).unwrap()[(0, 0)] / fit.residuals[(i, 0)]))
            .sum();
        assert!((left_out.freedom - trace).abs() < 1e-8, "h_ii = 1 - r_i / e_i");
    }
}

#[test]
fn samples_that_the_others_do_not_determine_have_no_error() {
    // Three samples define a plane; two do not.
    let sites = halton(1, 3, 2);
    let fit =
        Fit::new(&samples(&sites, &franke_at(&sites)), &Options::new(Kernel::ThinPlate)).unwrap();
    let left_out = fit.leave_one_out();
    assert_eq!(left_out.each(), [None; 3]);
    assert_eq!(left_out.mean_squares(&[vec![0]]), None);
    let five = halton(1, 5, 2);
    let fit =
        Fit::new(&samples(&five, &franke_at(&five)), &Options::new(Kernel::ThinPlate)).unwrap();
    let left_out = fit.leave_one_out();
    assert!(left_out.each().iter().all(Option::is_some));
    assert!(left_out.errors(&[0, 1, 2]).is_none(), "two samples are left");
}
