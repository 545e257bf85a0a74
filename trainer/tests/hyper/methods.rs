//! S1's own two methods, against the independent figures of `hbf_reference.json`.

use crate::problem::{Problem, options};
use crate::reference::{figures, median, reference};
use sinew_trainer::scattered::hyper::{Entries, Learned, Method, Metric, Options, Start};
use std::time::Instant;

/// Learns Franke's function by 12 centres from four seeds, of samples and starts, in 3,000 steps.
fn learned(method: Method) -> Vec<Learned> {
    let of = |seed: u64| {
        let options = Options {
            method,
            // Narrow, so that no start is better than the reference's.
            metric: Metric::scaled(2, 2, 8.0, Entries::Diagonal),
            start: Start::Random,
            seeds: vec![seed],
            evaluations: 3001,
            ..options(2, 12)
        };
        let begin = Instant::now();
        let learned = Problem::franke(seed, 300).learn(&options).unwrap();
        let rms = Problem::franke(1000 + seed, 2000).rms(&learned.sum);
        println!(
            "{method:?}, seed {seed}: {:.2} to {:.4}, {} taken, {rms:.5}, {:.2} s",
            learned.traces[0].start,
            learned.energy,
            learned.traces[0].accepted(),
            begin.elapsed().as_secs_f64()
        );
        learned
    };
    (1..=4).map(of).collect()
}

#[test]
fn a_gradient_flow_falls_as_far_as_the_independent_one() {
    let Some(reference) = reference() else { return };
    let reference = figures(&reference["euler_gradient_flow_energy"]);
    let learned = learned(Method::GradientFlow { step: 1.0 });
    assert!(learned.iter().all(|learned| learned.traces[0].start > reference[0]));
    let energy = median(learned.iter().map(|learned| learned.energy).collect());
    assert!(energy <= reference[reference.len() - 1], "{energy}");
    for Learned { traces, .. } in learned {
        // ω = 1 is too large here: it is halved at once, until it is not.
        assert!(!traces[0].steps[0].accepted && traces[0].accepted() > 2900);
    }
}

#[test]
fn metropolis_reaches_the_independent_energies() {
    let Some(reference) = reference() else { return };
    let runs = reference["metropolis"].as_array().unwrap();
    let of = |name: &str| runs.iter().map(|run| run[name].as_f64().unwrap()).collect::<Vec<_>>();
    let least = of("best").into_iter().fold(f64::INFINITY, f64::min);
    let worst_start = of("e0").into_iter().fold(0.0, f64::max);
    for temperatures in [[0.0, 0.0], [0.002, 0.002], [0.01, 0.0]] {
        let learned = learned(Method::Metropolis { reach: 1.0, temperatures });
        for Learned { energy, traces, .. } in learned {
            assert!(traces[0].start > worst_start && energy <= least, "{temperatures:?} {energy}");
            let rose = traces[0].steps.windows(2).any(|pair| pair[1].energy > pair[0].energy);
            assert_eq!(rose, temperatures[0] > 0.0);
        }
    }
}
