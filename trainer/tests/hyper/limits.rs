//! Limits of METHOD §3: interpolation, and a look-up table.

use crate::hyper::problem::{Problem, options};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use sinew_runtime::kernel::Kernel;
use sinew_trainer::regression::function::Exact;
use sinew_trainer::scattered::hyper::{Entries, Metric, Options, Start, learn};

/// Options with centres on all samples of a fixed metric, and coefficients solved once.
fn on_all(kernel: Kernel, samples: usize, metric: f64) -> Options {
    Options {
        kernel,
        metric: Metric::scaled(2, 2, metric, Entries::None),
        ridge: 0.0,
        start: Start::Random,
        evaluations: 1,
        ..options(2, samples)
    }
}

#[test]
fn centres_on_all_samples_of_a_fixed_metric_interpolate() {
    let (problem, others) = (Problem::franke(5, 40), Problem::franke(6, 200));
    for kernel in [
        Kernel::InverseMultiquadric,
        Kernel::InverseQuadratic,
        Kernel::Gaussian,
        Kernel::Matern12,
        Kernel::Matern32,
        Kernel::Matern52,
        Kernel::Wendland { l: 3 },
    ] {
        let learned = problem.learn(&on_all(kernel, 40, 8.0)).unwrap();
        let sites = |r: usize, c: usize| problem.sites[(r, c)];
        let squared = |i: usize, x: [f64; 2]| {
            64.0 * ((sites(i, 0) - x[0]).powi(2) + (sites(i, 1) - x[1]).powi(2))
        };
        let matrix =
            Mat::from_fn(40, 40, |i, j| kernel.exact(squared(i, [sites(j, 0), sites(j, 1)])));
        let solved = matrix.llt(Side::Lower).unwrap().solve(&problem.values);
        for site in others.sites.row_iter() {
            let x = [site[0], site[1]];
            let expected: f64 = (0..40).map(|i| solved[(i, 0)] * kernel.exact(squared(i, x))).sum();
            let found = learned.sum.evaluate(&x)[0];
            assert!((found - expected).abs() < 1e-10, "{kernel:?}: {found} {expected}");
        }
        assert!(learned.energy < 1e-20, "{kernel:?}: {}", learned.energy);
    }
}

#[test]
fn gaussians_of_no_width_are_a_look_up_table() {
    let problem = Problem::franke(7, 40);
    // The second value is 1 everywhere: it gives the sum of the gaussians' weights.
    let ones = Mat::from_fn(40, 1, |_, _| 1.0);
    let values = faer::concat![[&problem.values, &ones]];
    let (shift, scale) = ([0.0; 2], [1.0; 2]);
    let at = |width: f64| {
        let options = on_all(Kernel::Gaussian, 40, 1.0 / width);
        learn(problem.sites.as_ref(), values.as_ref(), &shift, &scale, &options).unwrap().sum
    };
    let entry = |i: usize| [problem.sites[(i, 0)], problem.sites[(i, 1)]];
    // A query in the table gives its entry; any other query gives 0.
    let table = at(1e-4);
    for i in 0..40 {
        assert!((table.evaluate(&entry(i))[0] - values[(i, 0)]).abs() < 1e-15);
    }
    assert_eq!(table.evaluate(&[0.123, 0.456]), [0.0, 0.0]);
    // Before the gaussians vanish, the ratio of the value to the sum of weights is the value of the
    // nearest entry. The share of wrong entries falls with the width.
    let queries = Problem::franke(8, 500).sites;
    let misses = |width: f64| {
        let sum = at(width);
        let missed = queries.row_iter().filter(|query| {
            let x = [query[0], query[1]];
            let distance = |i: &usize| (entry(*i)[0] - x[0]).hypot(entry(*i)[1] - x[1]);
            let nearest = (0..40).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
            let found = sum.evaluate(&x);
            let near = (found[0] / found[1] - values[(nearest, 0)]).abs() < 0.01;
            !near
        });
        missed.count()
    };
    let found = [0.1, 0.05, 0.02].map(misses);
    assert!(found.is_sorted_by(|a, b| a > b) && found[2] < 100, "{found:?}");
}
