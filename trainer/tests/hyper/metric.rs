//! Relevance of inputs by a learned metric.

use crate::hyper::problem::{Problem, options};
use faer::Mat;
use sinew_trainer::scattered::hyper::{Entries, Metric, Options};
use sinew_trainer::scattered::sum::KernelSum;

fn learned(problem: &Problem, centres: usize, seeds: Vec<u64>, metric: Metric) -> KernelSum {
    let options = Options { metric, seeds, ..options(problem.sites.ncols(), centres) };
    problem.learn(&options).unwrap().sum
}

#[test]
fn inputs_that_do_not_matter_lose_their_weights() {
    // As in `hbf_reference.json`: two of four inputs matter, all weights start at 2.
    for seed in 1..=4 {
        let of_two = |x: &[f64]| libm::sin(3.0 * x[0]) + x[0] * libm::cos(2.0 * x[1]);
        let problem = Problem::new(seed, 300, 4, of_two);
        let sum = learned(&problem, 16, vec![seed], Metric::scaled(4, 4, 2.0, Entries::Diagonal));
        let metric = sum.metric.as_ref().unwrap();
        let weights = [0, 1, 2, 3].map(|i| metric[(i, i)].abs());
        println!("seed {seed}: {weights:.5?}, rms {:.1e}", problem.rms(&sum));
        // Promised: 0.005.
        assert!(weights[2].max(weights[3]) <= 0.005 * weights[0].min(weights[1]), "{weights:?}");
        // The error of the reference.
        assert!(problem.rms(&sum) < 2.1e-4);
    }
}

#[test]
fn a_full_metric_finds_a_direction_that_a_diagonal_one_cannot() {
    let wave = |x: &[f64]| libm::sin(8.0 * (x[0] - x[1])) + 0.2 * x[0];
    let problem = Problem::new(1, 300, 2, wave);
    let rms = |entries| {
        let metric = Metric::scaled(2, 2, 4.0, entries);
        problem.rms(&learned(&problem, 10, vec![1, 2, 3, 4], metric))
    };
    let (diagonal, full) = (rms(Entries::Diagonal), rms(Entries::All));
    assert!(full < 0.01 * diagonal, "{full} {diagonal}");
}

#[test]
fn a_metric_of_low_rank_finds_the_direction_that_matters() {
    for seed in 1..=4 {
        let ridge = |x: &[f64]| libm::sin(2.5 * (0.8 * x[0] - 0.5 * x[1] + 0.3 * x[2]));
        let problem = Problem::new(seed, 200, 3, ridge);
        let metric = Metric { start: Mat::from_fn(1, 3, |_, _| 1.0), learned: Entries::All };
        let sum = learned(&problem, 6, vec![seed], metric);
        let row = sum.metric.as_ref().unwrap().row(0);
        let (along, length) = (0.8 * row[0] - 0.5 * row[1] + 0.3 * row[2], row.norm_l2());
        assert_eq!((sum.centres.nrows(), row.ncols()), (1, 3));
        let cosine = along.abs() / (length * 0.98f64.sqrt());
        assert!(cosine > 1.0 - 1e-6 && problem.rms(&sum) < 1e-3, "{row:?}");
    }
}

#[test]
fn parameters_that_are_not_learned_keep_their_start() {
    let problem = Problem::franke(1, 60);
    let start = Mat::from_fn(2, 2, |r, c| [[4.0, 0.5], [-0.5, 3.0]][r][c]);
    let of = |learned_entries| {
        let metric = Metric { start: start.clone(), learned: learned_entries };
        learned(&problem, 5, vec![1], metric).metric.unwrap()
    };
    let [none, diagonal, all] = [Entries::None, Entries::Diagonal, Entries::All].map(of);
    let changed = |w: &Mat<f64>| [(0, 0), (0, 1), (1, 0), (1, 1)].map(|at| w[at] != start[at]);
    assert_eq!(changed(&none), [false; 4]);
    assert_eq!(changed(&diagonal), [true, false, false, true]);
    assert_eq!(changed(&all), [true; 4]);
    let identity = Metric::scaled(2, 2, 1.0, Entries::None);
    assert!(learned(&problem, 5, vec![1], identity).metric.is_none(), "I is no metric");
}
