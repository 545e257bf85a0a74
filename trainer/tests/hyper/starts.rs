//! Samples on which centres start.

use crate::hyper::problem::{Problem, options};
use faer::Mat;
use sinew_trainer::scattered::hyper::{Entries, Metric, Options, Start};
use std::collections::BTreeSet;

/// Returns the samples on which centres start, as rows of a problem's sites.
fn chosen(problem: &Problem, start: Start, seed: u64, centres: usize) -> BTreeSet<usize> {
    let options = Options {
        start,
        metric: Metric::scaled(2, 2, 1.0, Entries::None),
        seeds: vec![seed],
        evaluations: 1,
        ..options(2, centres)
    };
    let sum = problem.learn(&options).unwrap().sum;
    let sample = |centre: usize| {
        let is =
            |i: &usize| (0..2).all(|c| problem.sites[(*i, c)] - 0.5 == sum.centres[(c, centre)]);
        (0..problem.sites.nrows()).find(is).unwrap()
    };
    (0..centres).map(sample).collect()
}

/// Makes ten samples around each of four points.
fn clusters() -> Problem {
    let at = |i: usize, c: usize| [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]][i / 10][c];
    let sites = Mat::from_fn(40, 2, |i, c| at(i, c) + 1e-4 * (7 * i + 3 * c) as f64);
    let values = Mat::from_fn(40, 1, |i, _| if i == 23 { 3.0 } else { 1.0 });
    Problem { sites, values }
}

#[test]
fn random_starts_draw_samples_uniformly() {
    let problem = clusters();
    let mut times = [0; 40];
    for seed in 0..400 {
        let chosen = chosen(&problem, Start::Random, seed, 10);
        assert_eq!(chosen.len(), 10, "a sample twice");
        chosen.into_iter().for_each(|i| times[i] += 1);
    }
    // Binomial: 100 on average, with a deviation of 8.7.
    assert!(times.iter().all(|n| (60..140).contains(n)), "{times:?}");
}

#[test]
fn k_means_plus_plus_takes_samples_apart() {
    let problem = clusters();
    let spread = |start| {
        let apart = (0..50).filter(|&seed| {
            let of = chosen(&problem, start, seed, 4).into_iter().map(|i| i / 10);
            of.collect::<BTreeSet<_>>().len() == 4
        });
        apart.count()
    };
    let (apart, any) = (spread(Start::KMeansPlusPlus), spread(Start::Random));
    assert!(apart == 50 && any < 25, "{apart} {any}");
}

#[test]
fn samples_that_repeat_are_no_trouble() {
    let sites = Mat::from_fn(12, 2, |_, _| 0.25);
    let values = Mat::from_fn(12, 1, |i, _| i as f64);
    let problem = Problem { sites, values };
    for start in [Start::Random, Start::KMeansPlusPlus] {
        let learned = problem.learn(&Options { start, ridge: 0.0, ..options(2, 5) }).unwrap();
        // With all centres at one place, the function is the mean.
        assert!((learned.sum.evaluate(&[0.25; 2])[0] - 5.5).abs() < 1e-12, "{start:?}");
    }
}
