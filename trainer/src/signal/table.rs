//! Covariances from estimates (METHOD §4), and covariances and signals from CSV files.

use super::covariance::Covariance;
pub use super::covariance::Table;
use crate::Error;
use crate::formats::csv;
use std::path::Path;

/// Divisor of an autocovariance's sums.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// The number of samples: positive definite.
    Biased,
    /// The number of pairs: usually not positive definite.
    Unbiased,
}

/// Reads a column of a CSV file with one finite number per row.
///
/// # Errors
/// If the file is not CSV, lacks the column, or has a cell that is not a finite number; with the line.
pub fn read_signal(path: &Path, column: &str) -> Result<Vec<f64>, Error> {
    let table = csv::read(path)?;
    let column = table.column(column)?;
    numbers(&table, column)
}

/// Reads a covariance from the first column of a CSV file, at lags of 0, 1, 2, ... samples. Also returns the clipped
/// share of the spectrum.
///
/// # Errors
/// Errors of [`read_signal`], except for a missing column; errors of [`Table::new`].
pub fn read_table(path: &Path) -> Result<(Covariance, f64), Error> {
    let table = csv::read(path)?;
    let (table, clipped) = Table::new(&numbers(&table, 0)?, 1.0)?;
    Ok((Covariance::Table(table), clipped))
}

/// Estimates the autocovariance of samples at the first `lags` lags, around their mean.
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

fn numbers(table: &csv::Table, column: usize) -> Result<Vec<f64>, Error> {
    let columns = [column];
    let rows = table.numbers(&columns);
    rows.map(|row| row.map(|(_, numbers)| numbers[0])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_divided_by_samples_or_by_pairs() {
        let samples = [1.0, -1.0, 1.0, -1.0];
        assert_eq!(autocovariance(&samples, 9, Estimator::Biased), [1.0, -0.75, 0.5, -0.25]);
        assert_eq!(autocovariance(&samples, 9, Estimator::Unbiased), [1.0, -1.0, 1.0, -1.0]);
    }
}
