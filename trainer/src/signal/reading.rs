//! Signals of files.

use super::covariance::Covariance;
use super::error::SignalError;
use super::table::Table;
use crate::formats::csv;
use std::path::Path;

/// Reads a column of a CSV: finite numbers, one a row.
///
/// # Errors
/// [`SignalError::Format`]: no CSV, no such column, a number that is none, by line.
pub fn read_signal(path: &Path, column: &str) -> Result<Vec<f64>, SignalError> {
    let table = csv::read(path)?;
    let column = table.column(column)?;
    numbers(&table, column)
}

/// Reads a covariance from the first column of a CSV: at lags of 0, 1, 2, ... samples. Also returns the share of its
/// spectrum that was negative and is clipped.
///
/// # Errors
/// [`SignalError::Format`] likewise, and those of [`Table::new`].
pub fn read_table(path: &Path) -> Result<(Covariance, f64), SignalError> {
    let table = csv::read(path)?;
    let (table, clipped) = Table::new(&numbers(&table, 0)?, 1.0)?;
    Ok((Covariance::Table(table), clipped))
}

fn numbers(table: &csv::Table, column: usize) -> Result<Vec<f64>, SignalError> {
    let columns = [column];
    let rows = table.numbers(&columns);
    rows.map(|row| Ok(row.map(|(_, numbers)| numbers[0])?)).collect()
}
