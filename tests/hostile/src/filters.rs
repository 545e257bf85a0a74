//! Filters of an accepted file, applied and held to what the runtime promises.

use models::Rng;
use sinew_runtime::filter::Samples;
use sinew_runtime::format::MAGNITUDE_MAX;
use sinew_runtime::{Argument, CallErrorKind, Filter};

/// Sizes of samples, from what the data holds to what is refused.
const SIZES: [f32; 6] = [0.5, 1.0, 0.0, 1e-20, 1e6, 3e38];

/// Taps that are worth a call's time.
const COST: usize = 1 << 14;

/// Reads all that a filter's accessors give.
///
/// # Panics
/// Where one lacks what a loaded filter must have, or where it asks for more than a file of its length may.
pub(crate) fn read_filter(filter: &Filter<'_>, file: &[u8]) {
    let (n, f) = (filter.tap_len(), filter.factor());
    assert!(4 * n * f * n <= file.len(), "a file of {} bytes has {n} taps", file.len());
    let is_finite = |x: Option<f32>| x.is_some_and(f32::is_finite);
    let rows = || (0..n).flat_map(|place| (0..f).map(move |phase| (place, phase)));
    assert!(
        rows().all(|(place, phase)| (0..n).all(|tap| is_finite(filter.tap(place, phase, tap))))
    );
    let has_variances = filter.variance(0, 0).is_some();
    assert!(rows().all(|(place, phase)| is_finite(filter.variance(place, phase)) == has_variances));
    for (sample, sample_len) in [(0, n), (n, 2 * n), (usize::MAX, n), (usize::MAX, usize::MAX)] {
        let (start, _) = filter.window(sample, sample_len);
        assert!(start <= sample_len - n);
    }
    let opened = filter.layout().open(file);
    assert!(opened.is_some_and(|opened| opened.counts() == filter.counts()));
}

/// Makes signals finer, of a shape by its number.
///
/// # Panics
/// Where a call is refused but for what is beyond measure, where a refused call has written, or where a result is not
/// finite.
pub(crate) fn evaluate_filter(filter: &Filter<'_>, number: usize) {
    let (n, f) = (filter.tap_len(), filter.factor());
    if n * f * n > COST {
        return;
    }
    let mut random = Rng(number as u64);
    let size = SIZES[number % SIZES.len()];
    let shape = Samples {
        signal_len: number % 3,
        sample_len: n + number % 5,
        lane_len: [0, 1, 3, 9][number % 4],
    };
    let len = shape.signal_len * shape.sample_len * shape.lane_len;
    let samples: Vec<f32> = (0..len).map(|_| size * random.unit()).collect();
    let mut out = vec![f32::NAN; len * f];
    match filter.apply(shape, &samples, &mut out) {
        Ok(()) => assert!(out.iter().all(|x| x.is_finite())),
        Err(error) => {
            assert!(out.iter().all(|x| x.is_nan()), "{error}: written");
            let of = (error.kind, error.argument);
            assert_eq!(of, (CallErrorKind::NonFinite, Argument::Samples), "{error}");
            assert!(samples[error.index].abs() > MAGNITUDE_MAX);
        }
    }
}
