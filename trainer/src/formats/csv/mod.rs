//! Tables as CSV: a line of names, then a row a line.

mod error;
mod read;

pub use error::CsvError;
pub(crate) use read::{Row, Table, read};
