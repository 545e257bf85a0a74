//! Reads covariance tables and signals from CSV files, and estimates covariances at lags (METHOD §4).

use super::covariance::Covariance;
use crate::Error;
use crate::formats::csv;
use std::path::Path;

pub use super::lags::Table;

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

/// Estimates the autocovariance of samples at the first `lags` lags, around their mean. Sums are divided by the number
/// of samples, so that the estimate is positive definite.
pub fn autocovariance(samples: &[f64], lags: usize) -> Vec<f64> {
    let n = samples.len();
    let mean = samples.iter().sum::<f64>() / n.max(1) as f64;
    let at = |lag: usize| {
        let pairs = samples.iter().zip(samples.get(lag..).unwrap_or_default());
        pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / n as f64
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
    fn products_are_divided_by_the_number_of_samples() {
        let samples = [1.0, -1.0, 1.0, -1.0];
        assert_eq!(autocovariance(&samples, 9), [1.0, -0.75, 0.5, -0.25]);
    }
}
