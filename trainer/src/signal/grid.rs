//! Filters that refine regular grids by an integer factor: taps by phase, with separate windows at both ends (METHOD
//! §4).

use super::faults::{too_short, wrong_number};
use super::functional::Functional;
use super::kriging::{Kriging, Process};
use crate::Error;

/// Most weights in a filter: a file of 256 MB.
const WEIGHTS: usize = 1 << 26;

/// Meaning of a signal's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sample {
    /// Point values: coarse samples at i, fine samples at i + f / F.
    Value,
    /// Averages: coarse samples over [i, i + 1], fine samples over 1 / F of that interval.
    Average,
}

/// Parameters of a filter.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// F, fine samples per coarse sample.
    pub factor: usize,
    /// N, coarse samples per window: odd.
    pub taps: usize,
    /// Meaning of the samples.
    pub sample: Sample,
}

/// Array layout: signals, then samples, then lanes. All lanes get the same filter.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Samples per signal.
    pub samples: usize,
    /// Numbers per sample.
    pub lanes: usize,
}

/// Filter weights for a regular grid.
#[derive(Clone, Debug)]
pub struct GridFilter {
    /// Parameters of the filter.
    pub grid: Grid,
    /// Weights of the window's coarse samples: N places in the window x F phases x N taps.
    pub weights: Vec<f64>,
    /// Variance of each fine sample, in units of C(0): N places x F phases.
    pub variances: Vec<f64>,
}

impl GridFilter {
    /// Computes the weights for a process; distances are in coarse samples.
    ///
    /// # Errors
    /// If the number of taps is even, the factor is 0, or there are too many weights; errors of [`Kriging::new`].
    pub fn new(process: &Process, grid: Grid) -> Result<Self, Error> {
        let Grid { factor, taps, sample } = grid;
        if taps % 2 == 0 {
            return Err(wrong_number("taps", "an odd number", taps as f64));
        }
        if factor < 1 {
            return Err(wrong_number("factor", "a number above 0", 0.0));
        }
        if taps.saturating_mul(taps).saturating_mul(factor) > WEIGHTS {
            let found = taps as f64 * taps as f64 * factor as f64;
            return Err(wrong_number("weights, taps x taps x factor", "at most 67,108,864", found));
        }
        let window: Vec<Functional> = (0..taps).map(|tap| sample.functional(tap, 0, 1)).collect();
        // The weights do not depend on the sample values.
        let kriging = Kriging::new(process, &window, &vec![0.0; taps])?;
        let (mut weights, mut variances) = (Vec::new(), Vec::new());
        for place in 0..taps {
            for phase in 0..factor {
                let fine = sample.functional(place, phase, factor);
                weights.extend(kriging.weights(&fine));
                variances.push(kriging.predict(&fine).variance);
            }
        }
        Ok(Self { grid, weights, variances })
    }

    /// Returns the window of a coarse sample in a signal of n samples: the window's start and the sample's place in the
    /// window.
    pub fn window(&self, sample: usize, n: usize) -> (usize, usize) {
        let start = sample.saturating_sub(self.grid.taps / 2).min(n.saturating_sub(self.grid.taps));
        (start, sample - start)
    }

    /// Refines signals: F fine samples per coarse sample.
    ///
    /// # Errors
    /// If a signal is shorter than a window.
    pub fn apply(&self, samples: &[f64], shape: Shape) -> Result<Vec<f64>, Error> {
        let Shape { samples: n, lanes } = shape;
        let Grid { factor, taps, .. } = self.grid;
        if n < taps {
            return Err(too_short(n, taps));
        }
        let mut out = vec![0.0; samples.len() * factor];
        let signals = samples.chunks_exact(n * lanes).zip(out.chunks_exact_mut(n * lanes * factor));
        for (coarse, fine) in signals {
            for (sample, fine) in fine.chunks_exact_mut(factor * lanes).enumerate() {
                let (start, place) = self.window(sample, n);
                let window = &coarse[start * lanes..][..taps * lanes];
                let phases = self.weights[place * factor * taps..].chunks_exact(taps);
                for (weights, fine) in phases.zip(fine.chunks_exact_mut(lanes)) {
                    for (weight, row) in weights.iter().zip(window.chunks_exact(lanes)) {
                        fine.iter_mut().zip(row).for_each(|(out, x)| *out += weight * x);
                    }
                }
            }
        }
        Ok(out)
    }

    /// Lists the variance of each fine sample of a signal with n coarse samples, in units of C(0).
    pub fn variances_of(&self, n: usize) -> Vec<f64> {
        let factor = self.grid.factor;
        let of = |sample: usize| &self.variances[self.window(sample, n).1 * factor..][..factor];
        (0..n).flat_map(of).copied().collect()
    }
}

impl Sample {
    /// Returns the functional that a fine sample observes; a factor of 1 gives the coarse sample.
    pub(super) fn functional(self, sample: usize, phase: usize, factor: usize) -> Functional {
        let at = |phase: usize| sample as f64 + phase as f64 / factor as f64;
        match self {
            Self::Value => Functional::Value { at: at(phase) },
            Self::Average => Functional::Average { from: at(phase), to: at(phase + 1) },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::covariance::Covariance;
    use super::super::kriging::Mean;
    use super::*;

    fn filter(sample: Sample, factor: usize, taps: usize) -> GridFilter {
        let covariance = Covariance::Matern32 { length: 2.0 };
        let process = Process { covariance, mean: Mean::Constant, noise: 0.0 };
        GridFilter::new(&process, Grid { factor, taps, sample }).unwrap()
    }

    #[test]
    fn averages_give_the_input_back_and_values_stay_where_they_are() {
        let samples: Vec<f64> = (0..23).map(|i| (0.8 * f64::from(i)).sin() + 7.0).collect();
        for factor in 1..5 {
            let shape = Shape { samples: 23, lanes: 1 };
            let fine = filter(Sample::Average, factor, 7).apply(&samples, shape).unwrap();
            for (fine, coarse) in fine.chunks(factor).zip(&samples) {
                let mean = fine.iter().sum::<f64>() / factor as f64;
                assert!((mean - coarse).abs() < 1e-10, "{factor}");
            }
            let fine = filter(Sample::Value, factor, 7).apply(&samples, shape).unwrap();
            for (fine, coarse) in fine.chunks(factor).zip(&samples) {
                assert!((fine[0] - coarse).abs() < 1e-10, "{factor}");
            }
        }
    }

    #[test]
    fn a_filter_as_long_as_the_signal_is_the_whole_system() {
        let samples = [1.0, 3.0, 2.0, -1.0, 0.5];
        for sample in [Sample::Value, Sample::Average] {
            let shape = Shape { samples: 5, lanes: 1 };
            let found = filter(sample, 3, 5).apply(&samples, shape).unwrap();
            let covariance = Covariance::Matern32 { length: 2.0 };
            let process = Process { covariance, mean: Mean::Constant, noise: 0.0 };
            let window: Vec<_> = (0..5).map(|i| sample.functional(i, 0, 1)).collect();
            let whole = Kriging::new(&process, &window, &samples).unwrap();
            for (place, found) in found.iter().enumerate() {
                let expected = whole.predict(&sample.functional(place / 3, place % 3, 3)).value;
                assert!((found - expected).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn lanes_and_signals_stay_apart() {
        let filter = filter(Sample::Average, 2, 3);
        let one = |of: &[f64]| filter.apply(of, Shape { samples: 4, lanes: 1 }).unwrap();
        let (a, b) = ([1.0, 2.0, 5.0, 3.0], [0.0, 4.0, 4.0, 1.0]);
        let both: Vec<f64> = a.iter().zip(b).flat_map(|(a, b)| [*a, b]).collect();
        let found = filter.apply(&both, Shape { samples: 4, lanes: 2 }).unwrap();
        let expected: Vec<f64> = one(&a).iter().zip(one(&b)).flat_map(|(a, b)| [*a, b]).collect();
        assert_eq!(found, expected);
        let found = filter.apply(&[a, b].concat(), Shape { samples: 4, lanes: 1 }).unwrap();
        assert_eq!(found, [one(&a), one(&b)].concat());
    }

    #[test]
    fn short_signals_and_even_windows_are_refused() {
        let filter = filter(Sample::Value, 2, 5);
        let short = filter.apply(&[1.0; 4], Shape { samples: 4, lanes: 1 }).unwrap_err();
        assert_eq!(short.to_string(), "4 samples are fewer than a window's 5: take fewer taps");
        let process = Process {
            covariance: Covariance::Matern32 { length: 1.0 },
            mean: Mean::Constant,
            noise: 0.0,
        };
        let even = "taps: expected an odd number, found ";
        let none = "factor: expected a number above 0, found ";
        for (factor, taps, expected) in [(2, 4, even), (0, 3, none), (2, 0, even)] {
            let grid = Grid { factor, taps, sample: Sample::Value };
            let error = GridFilter::new(&process, grid).unwrap_err();
            assert!(error.message().starts_with(expected), "{error}");
        }
    }
}
