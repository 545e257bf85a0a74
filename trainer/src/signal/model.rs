//! A named filter, its measured accuracy, and its part of a file.

use super::covariance::Covariance;
use super::grid::{Grid, GridFilter, Sample, Shape};
use super::kriging::Process;
use crate::Error;
use crate::bake::sections::{floats, names, narrow, words};
use crate::bake::{Part, Sections};
use sinew_runtime::filter::{FilterCounts, FilterFit};
use sinew_runtime::format::{Element, PartKind, SectionKind};

/// A filter for a signal.
#[derive(Clone, Debug)]
pub struct FilterModel {
    /// Name of the filter.
    pub name: String,
    /// Weights of the filter.
    pub filter: GridFilter,
    /// Variance of the process. Multiply the filter's variances by this number.
    pub variance: f64,
    /// Accuracy on left-out samples; `None` if the signal is too short for the measurement.
    pub fit: Option<LeftOut>,
}

/// Accuracy of predicting left-out samples: every F samples are replaced by the first, or by their mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeftOut {
    /// RMS error of a filter for the same process, in the signal's unit.
    pub rms: f64,
    /// RMS error of linear interpolation between the kept samples, in the signal's unit.
    pub linear_rms: f64,
    /// Samples in the incomplete last box, which are not measured.
    pub rest: usize,
}

impl LeftOut {
    /// Measures the prediction of left-out samples; `None` if the kept samples are fewer than a window.
    ///
    /// # Errors
    /// Errors of [`GridFilter::new`].
    pub fn new(samples: &[f64], process: &Process, grid: Grid) -> Result<Option<Self>, Error> {
        let Grid { factor, taps, sample } = grid;
        let boxes = samples.chunks_exact(factor);
        let rest = boxes.remainder().len();
        let kept: Vec<f64> = boxes
            .map(|samples| match sample {
                Sample::Value => samples[0],
                Sample::Average => samples.iter().sum::<f64>() / factor as f64,
            })
            .collect();
        if factor < 2 || kept.len() < taps {
            return Ok(None);
        }
        let covariance: Covariance = process.covariance.scaled(1.0 / factor as f64);
        let filter = GridFilter::new(&Process { covariance, ..process.clone() }, grid)?;
        let found = filter.apply(&kept, Shape { samples: kept.len(), lanes: 1 })?;
        let last = kept.len() - 1;
        // Linear interpolation connects the middles of boxes.
        let middle = if sample == Sample::Average { 0.5 } else { 0.0 };
        let line = |at: usize| {
            let place = (at as f64 + middle) / factor as f64 - middle;
            let place = place.clamp(0.0, last as f64);
            let (from, share) = (place as usize, place.fract());
            kept[from] * (1.0 - share) + kept[(from + 1).min(last)] * share
        };
        let (mut own, mut linear, mut count) = (0.0, 0.0, 0);
        // Linear interpolation ends at the last kept sample, so later samples are not measured.
        for (at, truth) in samples[..last * factor].iter().enumerate() {
            if sample == Sample::Average || at % factor != 0 {
                own += (found[at] - truth).powi(2);
                linear += (line(at) - truth).powi(2);
                count += 1;
            }
        }
        if count == 0 {
            return Ok(None);
        }
        let rms = |sum: f64| (sum / f64::from(count)).sqrt();
        Ok(Some(Self { rms: rms(own), linear_rms: rms(linear), rest }))
    }
}

/// Creates the filter part as FORMAT.md defines it.
///
/// - `variance`: writes the variance of each fine sample too, in the square of the signal's unit.
///
/// # Errors
/// If a count does not fit the file.
pub fn part(model: &FilterModel, variance: bool) -> Result<Part, Error> {
    let FilterModel { name, filter, variance: scale, fit } = model;
    let Grid { factor, taps, .. } = filter.grid;
    let counts =
        FilterCounts { factor: narrow("the factor", factor)?, tap_len: narrow("taps", taps)? };
    let mut sections: Sections = vec![
        (SectionKind::FilterCounts, true, words(&counts.words())),
        (SectionKind::Names, true, names(std::iter::once(name))?),
        (SectionKind::FilterTaps, true, floats(&filter.weights)),
    ];
    if variance {
        let own: Vec<f64> = filter.variances.iter().map(|x| x * scale).collect();
        sections.push((SectionKind::FilterVariances, true, floats(&own)));
    }
    let [left_out_rms, linear_rms] =
        fit.map_or([0.0; 2], |fit| [fit.rms, fit.linear_rms]).map(|x| x as f32);
    let fit = FilterFit { step: 1.0, left_out_rms, linear_rms };
    sections.push((SectionKind::FilterFit, true, floats(&fit.figures().map(f64::from))));
    Ok(Part { kind: PartKind::Filter, sections, element: Element::F32 })
}

#[cfg(test)]
mod tests {
    use super::super::kriging::Mean;
    use super::*;

    #[test]
    fn left_out_samples_of_a_wave_are_predicted_better_than_by_lines() {
        let samples: Vec<f64> = (0..121).map(|i| (0.7 * f64::from(i)).sin()).collect();
        let covariance =
            Covariance::Oscillating { length: 30.0, period: std::f64::consts::TAU / 0.7 };
        let process = Process { covariance, mean: Mean::Constant, noise: 0.0 };
        for sample in [Sample::Value, Sample::Average] {
            let grid = Grid { factor: 2, taps: 7, sample };
            let found = LeftOut::new(&samples, &process, grid).unwrap().unwrap();
            assert_eq!(found.rest, 1);
            assert!(found.rms < 0.3 * found.linear_rms, "{sample:?} {found:?}");
            let few = LeftOut::new(&samples[..12], &process, grid).unwrap();
            assert_eq!(few, None, "six are fewer than a window");
        }
    }
}
