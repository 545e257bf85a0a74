//! Filters of a file: the runtime in f32 must match f64.

use super::common::*;
use sinew_runtime::filter::Samples;
use sinew_runtime::format::Space;
use sinew_runtime::{Filter, Model};
use sinew_trainer::bake::bake;
use sinew_trainer::signal::grid::{Grid, GridFilter, Sample, Shape};
use sinew_trainer::signal::kriging::Mean;
use sinew_trainer::signal::model::part;
use sinew_trainer::signal::model::{FilterModel, LeftOut};

/// Roundings of a sum of 9 taps: of the taps, of the products and of the sums.
const ROUNDINGS: f64 = 12.0;
const U: f64 = 1.0 / (1 << 24) as f64;

#[test]
fn the_runtime_makes_the_same_signal() {
    for covariance in families() {
        for (factor, taps, sample) in
            [(4, 9, Sample::Value), (3, 7, Sample::Average), (1, 1, Sample::Value)]
        {
            let grid = Grid { factor, taps, sample };
            let filter =
                GridFilter::new(&process(covariance.clone(), Mean::Constant), grid).unwrap();
            let fit = LeftOut { rms: 0.25, linear_rms: 0.5, rest: 0 };
            let model =
                FilterModel { name: "signal".to_owned(), filter, variance: 2.0, fit: Some(fit) };
            let bytes = bake(Space::default(), &[part(&model, true).unwrap()]).unwrap();
            let file = Model::from_bytes(&bytes).unwrap();
            let loaded = file.all::<Filter>().next().unwrap();
            assert_eq!(
                (loaded.name(), loaded.factor(), loaded.tap_len()),
                ("signal", factor, taps)
            );
            assert_eq!(loaded.fit().figures(), [1.0, 0.25, 0.5]);
            let mut numbers = Numbers::new(2);
            for (signals, samples, lanes) in [(1, 31, 1), (2, 9, 5), (1, 10, 9)] {
                let coarse: Vec<f32> =
                    (0..signals * samples * lanes).map(|_| numbers.normal() as f32).collect();
                let wide: Vec<f64> = coarse.iter().map(|x| (*x).into()).collect();
                let expected = model.filter.apply(&wide, Shape { samples, lanes }).unwrap();
                let most = wide.iter().fold(0.0f64, |most, x| most.max(x.abs()));
                let sums =
                    model.filter.weights.chunks(taps).map(|row| row.iter().map(|w| w.abs()).sum());
                let bound = U * ROUNDINGS * most * sums.fold(0.0, f64::max);
                let mut found = vec![f32::NAN; expected.len()];
                let shape = Samples { signal_len: signals, sample_len: samples, lane_len: lanes };
                loaded.apply(shape, &coarse, &mut found).unwrap();
                for (found, expected) in found.iter().zip(&expected) {
                    assert!((f64::from(*found) - expected).abs() <= bound, "{found} {expected}");
                }
            }
            for place in 0..taps {
                for phase in 0..factor {
                    let expected = 2.0 * model.filter.variances[place * factor + phase];
                    assert_eq!(loaded.variance(place, phase), Some(expected as f32));
                }
            }
        }
    }
}

#[test]
fn variances_are_omitted_unless_requested() {
    let grid = Grid { factor: 2, taps: 3, sample: Sample::Value };
    let filter = GridFilter::new(&process(families().remove(1), Mean::Constant), grid).unwrap();
    let model = FilterModel { name: "s".to_owned(), filter, variance: 1.0, fit: None };
    let bytes = bake(Space::default(), &[part(&model, false).unwrap()]).unwrap();
    let file = Model::from_bytes(&bytes).unwrap();
    assert_eq!(file.all::<Filter>().next().unwrap().variance(0, 0), None);
}
