//! Covariances at even distances, made positive definite (METHOD §4).

use super::faults::{check_positive, no_observations, wrong_number};
use crate::Error;

/// Length of the circle on which the spectrum is computed, as a multiple of the number of lags.
const ROOM: usize = 8;

/// C at even distances, interpolated linearly, and 0 beyond the last: positive definite for places within that
/// distance.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    values: Vec<f64>,
    pub(super) step: f64,
}

impl Table {
    /// Creates a table from covariances at lags 0, 1, 2, ... with distance `step`, normalised by the first. Also
    /// returns the share of the spectrum that was negative and clipped.
    ///
    /// The spectrum of a sequence on a circle is its cosine transform. If the spectrum is nowhere negative, every
    /// matrix of the sequence is positive definite. Linear interpolation keeps this property, because it multiplies the
    /// spectrum by squares.
    ///
    /// # Errors
    /// If there is no covariance, the step or first covariance is not above 0, a covariance is not finite, or clipping
    /// leaves nothing.
    pub fn new(lags: &[f64], step: f64) -> Result<(Self, f64), Error> {
        check_positive("step", step)?;
        check_positive("covariance at lag 0", *lags.first().ok_or_else(no_observations)?)?;
        if let Some(&found) = lags.iter().find(|x| !x.is_finite()) {
            return Err(wrong_number("covariance", "a finite number", found));
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
            // Negative values from rounding alone do not count.
            negative += if *power < -1e-12 * lags[0] * len as f64 { -*power } else { 0.0 };
            *power = power.max(0.0);
        }
        let mut values = transform(&spectrum);
        values.truncate(len / 2 + 1);
        let first = values[0];
        if first.is_nan() || first <= 0.0 {
            return Err(Error::value("the table is not positive definite"));
        }
        values.iter_mut().for_each(|value| *value /= first);
        Ok((Self { values, step }, negative / all))
    }

    /// Evaluates C(d).
    pub(super) fn value(&self, d: f64) -> f64 {
        let at = d.abs() / self.step;
        let (lag, share) = (at as usize, at.fract());
        let of = |lag: usize| self.values.get(lag).copied().unwrap_or(0.0);
        of(lag) * (1.0 - share) + of(lag + 1) * share
    }

    /// Returns the distance beyond which C is 0.
    pub(super) fn reach(&self) -> f64 {
        self.step * self.values.len() as f64
    }
}

/// Computes the cosine transform of an even sequence on a circle. Two transforms multiply the sequence by its length.
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
    use crate::ErrorKind;

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
    fn invalid_tables_are_refused() {
        let empty = Table::new(&[], 1.0).unwrap_err();
        assert_eq!(empty.to_string(), "there are no observations");
        for (lags, step) in [(vec![0.0, 0.0], 1.0), (vec![1.0], 0.0), (vec![1.0, f64::NAN], 1.0)] {
            let error = Table::new(&lags, step).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Value);
            assert!(error.message().contains(": expected a finite number"), "{error}");
        }
    }
}
