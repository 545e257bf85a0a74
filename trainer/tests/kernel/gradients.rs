//! Jacobians of fitted functions, against central differences.

use crate::common::{halton, random, rows, samples};
use crate::reproduction::fitted;
use faer::Mat;
use sinew_trainer::scattered::solver::fit::Fit;
use sinew_trainer::scattered::solver::options::Options;

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
