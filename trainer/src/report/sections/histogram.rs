//! How many vertices err how much.

use super::series::legend;
use crate::page::chart::{Chart, Range};
use crate::page::html::paragraph;
use crate::report::comparison::Comparison;

/// Bins a decade.
const BINS: f64 = 10.0;
/// Decades below the largest error; what is smaller counts for the first bin.
const DECADES: f64 = 5.0;

/// A histogram of the errors of every vertex in every frame.
pub(super) fn errors(comparison: &Comparison<'_>) -> String {
    let series = comparison.series();
    let most = series.iter().map(|s| s.measured.errors().max_percent).fold(0.0, f64::max);
    if most == 0.0 {
        return paragraph("There is no error.");
    }
    let last = (BINS * most.log10()).floor();
    let first = last - BINS * DECADES + 1.0;
    let bins = (last - first) as usize + 1;
    let shares: Vec<Vec<f64>> = series
        .iter()
        .map(|series| {
            let measured = series.measured;
            let mut counts = vec![0_usize; bins];
            for place in 0..measured.frames.len() {
                for error in measured.percent_in(place) {
                    // That of 0 is before the first.
                    let bin = ((BINS * error.log10()).floor() - first).max(0.0) as usize;
                    counts[bin.min(bins - 1)] += 1;
                }
            }
            let all = counts.iter().sum::<usize>() as f64;
            counts.iter().map(|&count| 100.0 * count as f64 / all).collect()
        })
        .collect();
    let edge = |bin: usize| 10_f64.powf((first + bin as f64) / BINS);
    let highest = shares.iter().flatten().copied().fold(0.0, f64::max);
    let mut chart = Chart::new(
        (1130.0, 260.0),
        Range::between(edge(0), edge(bins)),
        Range::linear(0.0, 1.05 * highest),
    );
    chart.sides("error, % of the diagonal (logarithmic)", "share of the vertices, %");
    chart.numbers();
    for (series, shares) in series.iter().zip(&shares) {
        let steps: Vec<_> = shares
            .iter()
            .enumerate()
            .flat_map(|(bin, share)| [(edge(bin), *share), (edge(bin + 1), *share)])
            .collect();
        chart.area(series.class, &steps);
        chart.line(series.class, &steps);
    }
    paragraph("All vertices in all measured frames; the first bar also counts those that err less.")
        + &legend(comparison)
        + &chart.finish("histogram of the errors of all vertices")
}
