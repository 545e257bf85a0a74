//! The tolerance of stage filter.

use crate::filters::FilterSubject;
use sinew_trainer::regression::arithmetic::gamma;

/// Returns a number of a finer signal and its bound: a sum of N products that starts at 0.
///
/// - `place`: index of the number in the output of all signals.
pub fn filter(subject: &FilterSubject<'_>, place: usize) -> (f64, f64) {
    let (filter, shape) = (&subject.filter, subject.shape);
    let lane = place % shape.lane_len;
    let fine = place / shape.lane_len;
    let (coarse, phase) = (fine / filter.factor(), fine % filter.factor());
    let (signal, sample) = (coarse / shape.sample_len, coarse % shape.sample_len);
    // As FORMAT.md defines it.
    let n = filter.tap_len();
    let start = sample.saturating_sub((n - 1) / 2).min(shape.sample_len - n);
    let term = |tap: usize| {
        let at = (signal * shape.sample_len + start + tap) * shape.lane_len + lane;
        let weight = filter.tap(sample - start, phase, tap).expect("the filter has it");
        f64::from(weight) * f64::from(subject.samples[at])
    };
    let value = (0..n).map(term).sum();
    let magnitude: f64 = (0..n).map(|tap| term(tap).abs()).sum();
    (value, gamma(n + 1) * magnitude)
}
