//! Filters on signals and images, against sums written out.

use crate::common::{bits, call_error, length_error, short_error};
use models::{FilterContent, Pieces, Rng};
use sinew_runtime::filter::Samples;
use sinew_runtime::format::MAGNITUDE_MAX;
use sinew_runtime::{Argument, CallErrorKind, Filter, Model};

/// Filters samples by FORMAT.md, number by number.
fn expected(content: &FilterContent, shape: Samples, samples: &[f32]) -> Vec<f32> {
    let (f, n) = (content.factor as usize, content.tap_len as usize);
    let Samples { signal_len, sample_len, lane_len } = shape;
    let mut out = Vec::new();
    for signal in 0..signal_len {
        for fine in 0..sample_len * f {
            let (i, phase) = (fine / f, fine % f);
            let start = (i as isize - (n as isize - 1) / 2).clamp(0, (sample_len - n) as isize);
            let start = start as usize;
            for lane in 0..lane_len {
                let mut sum = 0.0;
                for tap in 0..n {
                    let weight = content.taps[((i - start) * f + phase) * n + tap];
                    let at = (signal * sample_len + start + tap) * lane_len + lane;
                    sum += weight * samples[at];
                }
                out.push(sum);
            }
        }
    }
    out
}

#[test]
fn every_shape_has_the_bits_of_a_sum_written_out() {
    let mut rng = Rng(60);
    for (factor, tap_len) in [(1, 1), (2, 5), (3, 3), (4, 9)] {
        let mut content = FilterContent::sample(factor, tap_len);
        content.taps.iter_mut().for_each(|tap| *tap += 0.1 * rng.unit());
        let bytes = Pieces::filter(&content).bytes();
        let model = Model::from_bytes(bytes.as_slice()).unwrap();
        let filter = model.first::<Filter>().unwrap();
        for (signal_len, more, lane_len) in
            [(1, 0, 1), (1, 12, 1), (3, 1, 3), (2, 4, 8), (2, 3, 19), (1, 2, 64)]
        {
            let shape = Samples { signal_len, sample_len: tap_len as usize + more, lane_len };
            let len = signal_len * shape.sample_len * lane_len;
            let samples: Vec<f32> = (0..len).map(|_| rng.unit()).collect();
            let mut out = vec![f32::NAN; len * factor as usize];
            filter.apply(shape, &samples, &mut out).unwrap();
            assert_eq!(bits(&out), bits(&expected(&content, shape, &samples)), "{shape:?}");
        }
    }
}

#[test]
fn an_image_is_two_calls() {
    // Taps that repeat a sample. On an image of 6 x 5 pixels with 3 channels they give each pixel
    // four times.
    let mut content = FilterContent::sample(2, 3);
    content.taps = (0..3)
        .flat_map(|place| (0..2).flat_map(move |_| (0..3).map(move |tap| f32::from(tap == place))))
        .collect();
    let bytes = Pieces::filter(&content).bytes();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let filter = model.first::<Filter>().unwrap();
    let (w, h, c) = (6, 5, 3);
    let image: Vec<f32> = (0..w * h * c).map(|x| x as f32).collect();
    let mut high = vec![f32::NAN; 2 * image.len()];
    let mut fine = vec![f32::NAN; 4 * image.len()];
    let columns = Samples { signal_len: 1, sample_len: h, lane_len: w * c };
    filter.apply(columns, &image, &mut high).unwrap();
    filter
        .apply(Samples { signal_len: 2 * h, sample_len: w, lane_len: c }, &high, &mut fine)
        .unwrap();
    for (at, found) in fine.iter().enumerate() {
        let (channel, x, y) = (at % c, at / c % (2 * w), at / c / (2 * w));
        assert_eq!(*found, image[(y / 2 * w + x / 2) * c + channel]);
    }
}

#[test]
fn wrong_calls_are_refused_and_nothing_is_written() {
    let bytes = Pieces::filter(&FilterContent::sample(2, 5)).bytes();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let filter = model.first::<Filter>().unwrap();
    let refused = |shape: Samples, samples: &[f32], out_len: usize| {
        let mut out = vec![7.0; out_len];
        let error = filter.apply(shape, samples, &mut out).unwrap_err();
        assert!(out.iter().all(|x| *x == 7.0));
        error
    };
    let six = Samples::of_signal(6);
    assert_eq!(refused(Samples::of_signal(4), &[0.0; 4], 8), short_error(Argument::Samples, 5, 4));
    assert_eq!(refused(six, &[0.0; 7], 12), length_error(Argument::Samples, 6, 7));
    assert_eq!(refused(six, &[0.0; 6], 11), length_error(Argument::Outputs, 12, 11));
    let many = Samples { signal_len: usize::MAX, ..six };
    assert_eq!(refused(many, &[0.0; 6], 12), length_error(Argument::Samples, usize::MAX, 6));
    for value in [f32::NAN, f32::INFINITY, -2.0 * MAGNITUDE_MAX] {
        let mut samples = [0.0; 6];
        samples[4] = value;
        let error = call_error(CallErrorKind::NonFinite, Argument::Samples);
        assert_eq!(refused(six, &samples, 12), sinew_runtime::CallError { index: 4, ..error });
    }
    // An empty input gives an empty output.
    let none = Samples { signal_len: 0, ..six };
    filter.apply(none, &[], &mut []).unwrap();
    filter.apply(Samples { lane_len: 0, ..six }, &[], &mut []).unwrap();
}

#[test]
fn the_largest_numbers_stay_finite() {
    let mut content = FilterContent::sample(1, 255);
    content.taps.fill(MAGNITUDE_MAX);
    let bytes = Pieces::filter(&content).bytes();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let mut out = [f32::NAN; 255];
    model
        .first::<Filter>()
        .unwrap()
        .apply(Samples::of_signal(255), &[MAGNITUDE_MAX; 255], &mut out)
        .unwrap();
    assert!(out.iter().all(|x| x.is_finite()));
}
