//! One row of numbers: a `.npy` array, or text with commas, spaces or line ends between them.

use super::error::FormatError;
use super::extension::{extension, unknown_format};
use super::npz::{ArrayError, read_npy};
use std::path::Path;

/// Reads the numbers of a `.npy`, `.txt` or `.csv` file, called `array` where something is wrong.
pub(crate) fn read(path: &Path, array: &str) -> Result<Vec<f64>, FormatError> {
    match extension(path).as_str() {
        "npy" => read_npy(path, array),
        "txt" | "csv" => {
            let text = std::fs::read_to_string(path).map_err(FormatError::Read)?;
            let numbers = text.split(|c: char| c == ',' || c == ';' || c.is_whitespace());
            let numbers = numbers.filter(|word| !word.is_empty());
            let parse = |(place, word): (usize, &str)| {
                word.parse().map_err(|_| {
                    let (array, word) = (array.to_owned(), word.to_owned());
                    ArrayError::NoNumber { array, place, word }.into()
                })
            };
            numbers.enumerate().map(parse).collect()
        }
        _ => Err(unknown_format(path, ".npy, .txt or .csv")),
    }
}
