//! A covariance as a table: estimated from data, and made positive definite (METHOD §4).

use super::error::{SignalError, check_positive};

/// Lags of the circle on which a table is made definite, over those that it is given.
const ROOM: usize = 8;

/// C at even distances, straight lines between, 0 beyond the last: positive definite for places that are no
/// farther apart than that.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    values: Vec<f64>,
    step: f64,
}

/// How products of so many pairs are divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// By the number of samples: positive definite.
    Biased,
    /// By the number of pairs: not, as a rule.
    Unbiased,
}

impl Table {
    /// Makes a table of covariances at lags 0, 1, 2, ... that are `step` apart, divided by the first; also
    /// returns the share of its spectrum that was negative and was clipped.
    ///
    /// Of a sequence on a circle the spectrum is its cosine transform, and where that is nowhere negative every
    /// matrix of the sequence is positive definite; lines between its numbers multiply it by squares.
    ///
    /// # Errors
    /// [`SignalError::Empty`]; [`SignalError::Number`] of a step or a first number that is not above 0, and
    /// of any that is not finite; [`SignalError::Indefinite`] where nothing is left.
    pub fn new(lags: &[f64], step: f64) -> Result<(Self, f64), SignalError> {
        check_positive("step", step)?;
        check_positive("covariance at lag 0", *lags.first().ok_or(SignalError::Empty)?)?;
        if let Some(&found) = lags.iter().find(|x| !x.is_finite()) {
            return Err(SignalError::Number {
                what: "covariance",
                expected: "a finite number",
                found,
            });
        }
        let len = (ROOM * lags.len()).next_power_of_two();
        let mut circle = vec![0.0; len];
        for (lag, value) in lags.iter().enumerate() {
            circle[lag] = *value;
            circle[(len - lag) % len] = *value;
        }
        let mut spectrum = transform(&circle);
        let (mut negative, mut all) = (0.0, 0.0);
        for power in &mut spectrum {
            all += power.abs();
            // What rounding alone makes negative is nothing to speak of.
            negative += if *power < -1e-12 * lags[0] * len as f64 { -*power } else { 0.0 };
            *power = power.max(0.0);
        }
        let mut values = transform(&spectrum);
        values.truncate(len / 2 + 1);
        let first = values[0];
        if first.is_nan() || first <= 0.0 {
            return Err(SignalError::Indefinite { what: "the table" });
        }
        values.iter_mut().for_each(|value| *value /= first);
        Ok((Self { values, step }, negative / all))
    }

    /// Evaluates C at a signed distance.
    pub(super) fn value(&self, d: f64) -> f64 {
        let at = d.abs() / self.step;
        let (lag, share) = (at as usize, at.fract());
        let of = |lag: usize| self.values.get(lag).copied().unwrap_or(0.0);
        of(lag) * (1.0 - share) + of(lag + 1) * share
    }

    /// Returns the distance from one number to the next.
    pub(super) const fn step(&self) -> f64 {
        self.step
    }

    /// Returns the distance beyond which it is 0.
    pub(super) fn reach(&self) -> f64 {
        self.step * self.values.len() as f64
    }

    /// Returns it for distances in another unit.
    pub(super) fn scaled(mut self, times: f64) -> Self {
        self.step *= times;
        self
    }
}

/// Estimates the autocovariance of samples at the first so many lags, their mean taken off.
pub fn autocovariance(samples: &[f64], lags: usize, estimator: Estimator) -> Vec<f64> {
    let n = samples.len();
    let mean = samples.iter().sum::<f64>() / n.max(1) as f64;
    let at = |lag: usize| {
        let pairs = samples.iter().zip(samples.get(lag..).unwrap_or_default());
        let sum: f64 = pairs.map(|(a, b)| (a - mean) * (b - mean)).sum();
        sum / match estimator {
            Estimator::Biased => n as f64,
            Estimator::Unbiased => (n - lag) as f64,
        }
    };
    (0..lags.min(n)).map(at).collect()
}

/// Computes the cosine transform of an even sequence on a circle; twice, it is so many times itself.
fn transform(circle: &[f64]) -> Vec<f64> {
    let len = circle.len();
    let cosines: Vec<f64> =
        (0..len).map(|k| libm::cos(std::f64::consts::TAU * k as f64 / len as f64)).collect();
    let at = |frequency: usize| {
        circle.iter().enumerate().map(|(k, x)| x * cosines[k * frequency % len]).sum()
    };
    (0..len).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definite_table_is_kept_and_an_indefinite_one_is_clipped() {
        let triangle = [1.0, 0.75, 0.5, 0.25];
        let (table, clipped) = Table::new(&triangle, 2.0).unwrap();
        assert_eq!(clipped, 0.0);
        for (lag, expected) in triangle.iter().enumerate() {
            assert!((table.value(2.0 * lag as f64) - expected).abs() < 1e-12);
        }
        assert!((table.value(-3.0) - 0.625).abs() < 1e-12, "lines between");
        let (table, clipped) = Table::new(&[1.0, 0.9, -0.9], 1.0).unwrap();
        assert!((0.05..0.5).contains(&clipped), "{clipped}");
        assert!((table.value(0.0) - 1.0).abs() < 1e-15 && table.value(1.0) < 0.9);
    }

    #[test]
    fn what_is_no_covariance_is_refused() {
        assert!(matches!(Table::new(&[], 1.0), Err(SignalError::Empty)));
        for (lags, step) in [(vec![0.0, 0.0], 1.0), (vec![1.0], 0.0), (vec![1.0, f64::NAN], 1.0)] {
            assert!(matches!(Table::new(&lags, step), Err(SignalError::Number { .. })));
        }
    }

    #[test]
    fn products_are_divided_by_samples_or_by_pairs() {
        let samples = [1.0, -1.0, 1.0, -1.0];
        assert_eq!(autocovariance(&samples, 9, Estimator::Biased), [1.0, -0.75, 0.5, -0.25]);
        assert_eq!(autocovariance(&samples, 9, Estimator::Unbiased), [1.0, -1.0, 1.0, -1.0]);
    }
}
