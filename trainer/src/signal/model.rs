//! A filter with its name and what it reaches on the signal that it was made for.

use super::covariance::Covariance;
use super::error::SignalError;
use super::grid::{Grid, GridFilter, Sample, Shape};
use super::kriging::Process;

/// A filter for a signal.
#[derive(Clone, Debug)]
pub struct FilterModel {
    /// Its name.
    pub name: String,
    /// The weights.
    pub filter: GridFilter,
    /// The variance of the process, by which those of the filter are to be multiplied.
    pub variance: f64,
    /// What it reaches; none of a signal too short to tell.
    pub fit: Option<LeftOut>,
}

/// How well samples that were left out are predicted: of every F samples one is kept, or their mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeftOut {
    /// RMS error of a filter of the same process, in the signal's unit.
    pub rms: f64,
    /// That of lines between the kept samples.
    pub linear_rms: f64,
    /// Samples at the end that do not fill a box and took no part.
    pub rest: usize,
}

impl LeftOut {
    /// Leaves samples out of a signal and predicts them; none where too few are left for a window.
    ///
    /// # Errors
    /// Those of [`GridFilter::new`].
    pub fn new(
        samples: &[f64],
        process: &Process,
        grid: Grid,
    ) -> Result<Option<Self>, SignalError> {
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
        // Lines go between the middles of boxes.
        let middle = if sample == Sample::Average { 0.5 } else { 0.0 };
        let line = |at: usize| {
            let place = (at as f64 + middle) / factor as f64 - middle;
            let place = place.clamp(0.0, last as f64);
            let (from, share) = (place as usize, place.fract());
            kept[from] * (1.0 - share) + kept[(from + 1).min(last)] * share
        };
        let (mut own, mut linear, mut count) = (0.0, 0.0, 0);
        // Nothing is beyond the last kept value for a line to go to.
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

#[cfg(test)]
mod tests {
    use super::super::mean::Mean;
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
