//! Samples and polynomials are reproduced; fewer centres, weights, widths and smoothing have their
//! documented effects.

use crate::kernel::common::{apart, evaluate, franke_at, halton, random, rows, samples, wahba_at};
use faer::Mat;
use sinew_runtime::kernel::{EulerOrder, Kernel};
use sinew_trainer::ErrorKind;
use sinew_trainer::regression::function::Exact;
use sinew_trainer::regression::rotations::{Feature, from_euler};
use sinew_trainer::scattered::solver::choose::{Choice, Freedom};
use sinew_trainer::scattered::solver::fit::Fit;
use sinew_trainer::scattered::solver::leave_one_out::Variance;
use sinew_trainer::scattered::solver::options::{Options, wendland};
use sinew_trainer::scattered::solver::report::FitReport;
use sinew_trainer::scattered::solver::samples::{Conflicts, Samples};
use sinew_trainer::scattered::solver::scaling::Block;
use sinew_trainer::scattered::sum::{KernelSum, monomials, powers};

/// Width and smoothing are to be chosen.
const BOTH: Freedom = Freedom { epsilon: true, smoothing: true };

/// Lists the kernels for fits in d inputs.
pub(crate) fn fitted(d: usize) -> impl Iterator<Item = Kernel> {
    let own = |kernel: &Kernel| !matches!(kernel, Kernel::Wendland { .. } | Kernel::Hat { .. });
    Kernel::ALL.into_iter().filter(own).chain(wendland(d))
}

#[test]
fn samples_are_reproduced_by_every_kernel() {
    for (n, d) in [(2, 1), (12, 1), (40, 2), (60, 3), (80, 5)] {
        let sites = halton(1, n, d);
        let values = Mat::from_fn(n, 2, |i, o| 7.0 + (3.0 * sites[(i, 0)] + o as f64).sin());
        let samples = samples(&sites, &values);
        for kernel in fitted(d) {
            let options = Options { epsilon: 2.0, ..Options::new(kernel) };
            let fit = Fit::new(&samples, &options).unwrap();
            let missed = apart(&evaluate(&fit.sum, &sites), &values);
            assert!(missed < 1e-10, "{kernel:?} {n} {d} {missed:.1e}");
        }
    }
}

#[test]
fn polynomials_are_reproduced_by_every_kernel_smoothed_or_not() {
    let (sites, queries) = (halton(1, 40, 2), halton(100, 200, 2));
    for kernel in fitted(2) {
        for degree in 2..4 {
            let terms = monomials(2, degree);
            let coefficients = random(degree as u64, terms.len(), 2);
            let of = |points: &Mat<f64>| {
                let values: Vec<_> = rows(points).iter().map(|x| powers(&terms, x)).collect();
                Mat::from_fn(values.len(), terms.len(), |i, t| values[i][t]) * &coefficients
            };
            for smoothing in [0.0, 0.1] {
                let options = Options {
                    smoothing,
                    degree: Some(degree),
                    epsilon: 3.0,
                    ..Options::new(kernel)
                };
                let fit = Fit::new(&samples(&sites, &of(&sites)), &options).unwrap();
                let missed = apart(&evaluate(&fit.sum, &queries), &of(&queries));
                assert!(missed < 1e-10, "{kernel:?} {degree} {missed:.1e}");
            }
        }
    }
}

#[test]
fn degenerate_sites_keep_their_polynomials() {
    // Nine entries of a hinge's rotation matrix: four vary, in a plane.
    let turn = |i: usize| from_euler(EulerOrder::Xyz, [0.0, 0.0, 7.0 * i as f64]);
    let sites: Vec<Vec<f64>> = (0..14).map(|i| Feature::Matrix.of(turn(i)).unwrap()).collect();
    let sites = Mat::from_fn(14, 9, |i, c| sites[i][c]);
    let values = Mat::from_fn(14, 1, |i, _| 2.0 + sites[(i, 1)] - 3.0 * sites[(i, 4)]);
    let blocks = [Block { len: 9, weight: 1.0 }];
    let samples = Samples::new(&sites, &values, &blocks, Conflicts::Refuse).unwrap();
    let options = Options::new(Kernel::ThinPlate);
    let fit = Fit::new(&samples, &options).unwrap();
    let report = FitReport::new(&samples, &options, &fit);
    assert_eq!((report.degree, report.rank, report.terms), (Some(1), 3, 5));
    assert_eq!(report.dropped, [2, 5, 6, 7, 8]);
    let between = Feature::Matrix.of(from_euler(EulerOrder::Xyz, [0.0, 0.0, 31.5])).unwrap();
    let expected = 2.0 + between[1] - 3.0 * between[4];
    assert!((fit.sum.evaluate(&between)[0] - expected).abs() < 1e-10, "linear in the entries");
}

#[test]
fn too_few_samples_lower_the_degree_and_say_so() {
    let sites = halton(1, 5, 2);
    let samples = samples(&sites, &franke_at(&sites));
    let options = Options::new(Kernel::Quintic);
    let fit = Fit::new(&samples, &options).unwrap();
    let report = FitReport::new(&samples, &options, &fit);
    assert_eq!((report.degree_asked, report.degree), (Some(2), Some(1)));
    assert!(apart(&evaluate(&fit.sum, &sites), &samples.values) < 1e-10);
}

#[test]
fn weights_are_one_at_their_sample_and_sum_to_one() {
    let sites = halton(1, 9, 2);
    let blocks = [Block { len: 1, weight: 1.0 }; 2];
    let samples = Samples::of_weights(&sites, &blocks).unwrap();
    let fit = Fit::new(&samples, &Options::new(Kernel::ThinPlate)).unwrap();
    assert!(apart(&evaluate(&fit.sum, &sites), &Mat::identity(9, 9)) < 1e-12);
    for query in rows(&halton(50, 20, 2)) {
        let sum: f64 = fit.sum.evaluate(&query).iter().sum();
        assert!((sum - 1.0).abs() < 1e-10, "constants are reproduced");
    }
}

#[test]
fn few_centres_are_the_least_squares_of_the_penalty() {
    let sites = halton(1, 30, 2);
    let samples = samples(&sites, &franke_at(&sites));
    let options = Options {
        smoothing: 1e-3,
        epsilon: 2.0,
        centres: Some(4),
        ..Options::new(Kernel::ThinPlate)
    };
    let fit = Fit::new(&samples, &options).unwrap();
    assert_eq!(fit.sum.centres.ncols(), 4);
    let penalised = |coefficients: &Mat<f64>| {
        let mut sum = fit.sum.clone();
        sum.coefficients = coefficients.clone();
        let left = evaluate(&sum, &sites) - &samples.values;
        left.squared_norm_l2() + 1e-3 * 30.0 * coefficients.squared_norm_l2()
    };
    let least = penalised(&fit.sum.coefficients);
    for k in 0..fit.sum.coefficients.ncols() {
        for step in [-1e-4, 1e-4] {
            let mut moved = fit.sum.coefficients.clone();
            moved[(0, k)] += step;
            assert!(penalised(&moved) > least, "coefficient {k}");
        }
    }
    let more = Options { smoothing: 0.0, centres: Some(29), ..options };
    // The power function chooses at most as many centres as the samples determine: with three
    // polynomials 27.
    let most = Fit::new(&samples, &more).unwrap();
    assert_eq!(most.sum.centres.ncols(), 27);
    assert!(apart(&evaluate(&most.sum, &sites), &franke_at(&sites)) < 1e-10);
}

#[test]
fn more_centres_come_nearer() {
    let (sites, queries) = (halton(1, 120, 2), halton(200, 200, 2));
    let samples = samples(&sites, &franke_at(&sites));
    let options = Options { smoothing: 1e-9, epsilon: 2.0, ..Options::new(Kernel::Gaussian) };
    let rms = |count: usize| {
        let fit = Fit::new(&samples, &Options { centres: Some(count), ..options }).unwrap();
        (evaluate(&fit.sum, &queries) - franke_at(&queries)).norm_l2() / 200f64.sqrt()
    };
    let found = [8, 20, 40].map(rms);
    assert!(found.is_sorted_by(|a, b| a > b) && found[2] < 0.02, "{found:?}");
}

#[test]
fn uncorrelated_samples_are_still_joined() {
    let sites = Mat::from_fn(5, 1, |i, _| i as f64);
    let samples = samples(&sites, &Mat::from_fn(5, 1, |i, _| [0.2, 0.8, 0.1, 0.9, 0.3][i]));
    let groups: Vec<Vec<usize>> = (0..5).map(|i| vec![i]).collect();
    for kernel in [Kernel::Gaussian, Kernel::Matern52, Kernel::Wendland { l: 3 }] {
        let epsilons = Freedom { epsilon: true, smoothing: false };
        let choice = Choice::new(&samples, &Options::new(kernel), epsilons, &groups, None).unwrap();
        // Neighbouring sites are 1 apart; the mean distance is 2.
        let next = kernel.exact((choice.options.epsilon / 2.0).powi(2)) / kernel.exact(0.0);
        assert!(next >= (-1f64).exp(), "{kernel:?}: {}", choice.options.epsilon);
    }
}

#[test]
fn widths_are_chosen_whatever_the_spacing_and_whether_samples_can_be_left_out_or_not() {
    let width = |sites: &Mat<f64>, values: &Mat<f64>, groups: &[Vec<usize>], options: Options| {
        let free = Freedom { epsilon: true, smoothing: false };
        Choice::new(&samples(sites, values), &options, free, groups, None).unwrap().options.epsilon
    };
    // 400 samples on a line: every width relative to the mean distance is singular.
    let line = Mat::from_fn(400, 1, |i, _| i as f64);
    let wave = Mat::from_fn(400, 1, |i, _| (0.05 * i as f64).sin());
    let each: Vec<Vec<usize>> = (0..400).map(|i| vec![i]).collect();
    assert!(width(&line, &wave, &each, Options::new(Kernel::Gaussian)) > 8.0);
    // Wendland's kernel of 40 inputs falls below 1/e at an eighth of the mean distance.
    let many = random(8, 50, 40);
    let each: Vec<Vec<usize>> = (0..50).map(|i| vec![i]).collect();
    let kernel = sinew_trainer::scattered::solver::options::wendland(40).unwrap();
    assert!(width(&many, &random(9, 50, 1), &each, Options::new(kernel)) < 0.125);
    // One group of all samples leaves none to predict it: the requested width stays.
    let (few, own) = (halton(1, 5, 2), random(10, 5, 1));
    let all = [(0..5).collect::<Vec<usize>>()];
    assert_eq!(width(&few, &own, &all, Options::new(Kernel::Gaussian)), 1.0);
}

#[test]
fn the_choice_is_near_the_best_of_a_dense_search() {
    let (sites, queries) = (halton(1, 40, 2), halton(200, 300, 2));
    let noise = random(6, 40, 1);
    let truth = franke_at(&sites);
    let groups: Vec<Vec<usize>> = (0..40).map(|i| vec![i]).collect();
    let error =
        |fit: &Fit| (evaluate(&fit.sum, &queries) - franke_at(&queries)).norm_l2() / 300f64.sqrt();
    for amount in [0.0, 0.1] {
        let samples =
            samples(&sites, &Mat::from_fn(40, 1, |i, _| truth[(i, 0)] + amount * noise[(i, 0)]));
        for kernel in [Kernel::Gaussian, Kernel::ThinPlate] {
            let start = Options::new(kernel);
            let choice = Choice::new(&samples, &start, BOTH, &groups, None).unwrap();
            let chosen = Fit::new(&samples, &choice.options).unwrap();
            let score = |fit: &Fit| fit.leave_one_out().mean_squares(&groups).unwrap()[0];
            let mut best_error = f64::INFINITY;
            let mut best_score = f64::INFINITY;
            for e in 0..13 {
                for l in 0..13 {
                    let epsilon = if kernel == Kernel::ThinPlate {
                        1.0
                    } else {
                        2f64.powf(0.5 * f64::from(e) - 3.0)
                    };
                    let smoothing = 10f64.powf(-f64::from(l));
                    let Ok(fit) = Fit::new(&samples, &Options { epsilon, smoothing, ..start })
                    else {
                        continue;
                    };
                    best_error = best_error.min(error(&fit));
                    best_score = best_score.min(score(&fit));
                }
            }
            assert!(score(&chosen) < 1.05 * best_score, "{kernel:?} {amount}");
            assert!(error(&chosen) < 2.0 * best_error, "{kernel:?} {amount}");
            if amount > 0.0 {
                assert!(choice.options.smoothing > 0.0, "noise is smoothed");
            }
        }
    }
    let two = samples(&halton(1, 2, 1), &Mat::from_fn(2, 1, |i, _| i as f64));
    let both = [vec![0, 1]];
    let refused = Choice::new(&two, &Options::new(Kernel::Linear), BOTH, &both, None).unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::Fit);
    assert!(refused.message().starts_with("no smoothing can be chosen: "), "{refused}");
}

#[test]
fn variances_are_those_of_the_conditioned_process() {
    let (sites, queries) = (halton(1, 18, 2), halton(60, 30, 2));
    for (kernel, degree) in [
        (Kernel::Gaussian, None),
        (Kernel::Matern32, Some(0)),
        (Kernel::ThinPlate, Some(1)),
        (Kernel::Linear, Some(0)),
    ] {
        for smoothing in [0.0, 0.05] {
            let values = franke_at(&sites);
            let options = Options { degree, smoothing, epsilon: 3.0, ..Options::new(kernel) };
            let fit = Fit::new(&samples(&sites, &values), &options).unwrap();
            let variance = fit.variance(&values).unwrap();
            for query in rows(&queries) {
                let found = variance_at(&variance, &fit.sum, &query);
                let expected = textbook(&fit, kernel, &sites, smoothing, &query);
                assert!(
                    (found - expected).abs() < 1e-9 * (1.0 + expected),
                    "{kernel:?} {found} {expected}"
                );
            }
            let at_sample = variance_at(&variance, &fit.sum, &rows(&sites)[4]);
            assert!(if smoothing == 0.0 { at_sample < 1e-12 } else { at_sample > 1e-3 });
        }
    }
}

/// Computes the variance at a query from the matrices that a file holds.
fn variance_at(variance: &Variance, sum: &KernelSum, query: &[f64]) -> f64 {
    let (g, p) = sum.basis(query);
    let column = |of: &[f64]| Mat::from_fn(of.len(), 1, |i, _| of[i]);
    let (g, p) = (column(&g), column(&p));
    let explained = &variance.whitening * faer::concat![[&g], [&p]];
    let linear = (g.transpose() * (&variance.reproducing * &p))[(0, 0)];
    let square = (p.transpose() * &variance.polynomial * &p)[(0, 0)];
    (sum.kernel.exact(0.0) - 2.0 * linear + square - explained.squared_norm_l2()).max(0.0)
}

/// Computes `G(0) - [g; p]ᵀ S⁻¹ [g; p]`, by elimination of the whole system.
fn textbook(fit: &Fit, kernel: Kernel, sites: &Mat<f64>, smoothing: f64, query: &[f64]) -> f64 {
    use faer::linalg::solvers::Solve;
    use sinew_trainer::regression::function::Exact;
    let bases: Vec<_> = rows(sites).iter().map(|x| fit.sum.basis(x)).collect();
    let (n, t) = (bases.len(), fit.sum.terms.len());
    let whole = Mat::from_fn(n + t, n + t, |i, k| match (i < n, k < n) {
        (true, true) => bases[i].0[k] + if i == k { smoothing } else { 0.0 },
        (true, false) => bases[i].1[k - n],
        (false, true) => bases[k].1[i - n],
        (false, false) => 0.0,
    });
    let (g, p) = fit.sum.basis(query);
    let right = Mat::from_fn(n + t, 1, |i, _| if i < n { g[i] } else { p[i - n] });
    kernel.exact(0.0) - (right.transpose() * whole.partial_piv_lu().solve(&right))[(0, 0)]
}

#[test]
fn deviations_are_those_of_the_likeliest_process() {
    // Values of twice the size have twice the deviation; a constant has none besides a constant
    // term.
    let sites = halton(1, 20, 1);
    let y = wahba_at(&sites);
    let values = Mat::from_fn(20, 3, |i, o| [y[(i, 0)], 2.0 * y[(i, 0)], 5.0][o]);
    let options = Options { epsilon: 4.0, ..Options::new(Kernel::Matern32) };
    let fit = Fit::new(&samples(&sites, &values), &options).unwrap();
    let [one, two, none] = fit.variance(&values).unwrap().deviations[..] else { panic!() };
    // 20 samples and a constant term: 19 degrees of freedom.
    let energy: f64 = (0..20).map(|k| fit.sum.coefficients[(0, k)] * y[(k, 0)]).sum();
    assert!((one * one / (energy / 19.0) - 1.0).abs() < 1e-9);
    assert!((two / one - 2.0).abs() < 1e-9 && none < 1e-6 * one);
}

#[test]
fn reports_list_merged_rows_dropped_inputs_and_residuals() {
    let sites = Mat::from_fn(12, 3, |i, c| match c {
        0 => (0.7 * (i % 11) as f64).sin(),
        1 => 4.0,
        _ => (0.4 * (i % 11) as f64).cos(),
    });
    let values = Mat::from_fn(12, 1, |i, _| ((i % 11) as f64).sqrt());
    let samples = samples(&sites, &values);
    let options = Options { smoothing: 0.01, ..Options::new(Kernel::Gaussian) };
    let fit = Fit::new(&samples, &options).unwrap();
    let report = FitReport::new(&samples, &options, &fit);
    assert_eq!((report.samples, report.inputs, report.values, report.centres), (11, 3, 1, 11));
    assert_eq!((report.merged[0].row, report.merged[0].into), (11, 0));
    assert_eq!(report.dropped, [1]);
    let left = &samples.values - evaluate(&fit.sum, &samples.sites);
    assert!((report.residual_max - left.norm_max()).abs() < 1e-12);
    assert!((report.residual_rms - left.norm_l2() / 11f64.sqrt()).abs() < 1e-12);
    assert!(report.freedom > 1.0 && report.freedom < 11.0 && report.rcond > 1e-6);
    assert!(report.left_out.iter().all(|e| e.is_some()));
    let json = serde_json::to_value(&report).unwrap();
    assert_eq!(json["kernel"], "gaussian");
    let options = Options { centres: Some(4), ..options };
    let report = FitReport::new(&samples, &options, &Fit::new(&samples, &options).unwrap());
    assert_eq!((report.centres, report.rank), (4, 1));
    assert!(report.freedom < 5.0 && report.left_out_rms.is_some());
}

#[test]
fn values_far_from_zero_are_no_worse_conditioned() {
    let sites = halton(1, 40, 2);
    let far = Mat::from_fn(40, 1, |i, _| 1e9 + franke_at(&sites)[(i, 0)]);
    for kernel in fitted(2) {
        let fit =
            Fit::new(&samples(&sites, &far), &Options { epsilon: 3.0, ..Options::new(kernel) });
        assert!(apart(&evaluate(&fit.unwrap().sum, &sites), &far) < 1e-5, "{kernel:?}");
    }
}

#[test]
fn jacobians_are_central_differences_away_from_samples() {
    for d in 1..=4 {
        let sites = halton(1, 30, d);
        let values = Mat::from_fn(30, 2, |i, o| {
            (0..d).map(|c| (2.0 * sites[(i, c)] + (c + o) as f64).sin()).sum()
        });
        let samples = samples(&sites, &values);
        for kernel in fitted(d) {
            for degree in [0, 1, 2] {
                let options =
                    Options { degree: Some(degree), epsilon: 5.0, ..Options::new(kernel) };
                if options.check().is_err() {
                    continue;
                }
                let sum = Fit::new(&samples, &options).unwrap().sum;
                for query in rows(&random(d as u64, 20, d)) {
                    let near = |site: &Vec<f64>| {
                        site.iter().zip(&query).map(|(a, b)| (a - b).powi(2)).sum::<f64>() < 1e-4
                    };
                    if rows(&sites).iter().any(near) {
                        continue;
                    }
                    let found = sum.jacobian(&query);
                    for c in 0..d {
                        let at = |h: f64| {
                            let mut moved = query.clone();
                            moved[c] += h;
                            sum.evaluate(&moved)
                        };
                        let (after, before) = (at(1e-5), at(-1e-5));
                        for o in 0..2 {
                            let expected = (after[o] - before[o]) / 2e-5;
                            let missed = (found[(o, c)] - expected).abs();
                            assert!(
                                missed < 1e-6 * (1.0 + expected.abs()),
                                "{kernel:?} {d} {degree} {missed:.1e}"
                            );
                        }
                    }
                }
            }
        }
    }
}
