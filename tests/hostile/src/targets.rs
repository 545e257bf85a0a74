//! The bodies of the fuzz targets. Each panics at a finding and does nothing else of note.

use crate::evaluate::{evaluate, read};
use crate::poses::KINDS;
use crate::recipe;
use models::seal;
use sinew_runtime::{FileError, Model};
use std::ops::Range;

/// Loads any bytes, and reads what was accepted.
///
/// # Errors
/// Why the bytes were refused.
pub fn load(data: &[u8]) -> Result<(), FileError> {
    Model::from_bytes(data).map(|model| read(&model))
}

/// Loads any bytes, and evaluates what was accepted.
///
/// # Errors
/// Why the bytes were refused.
pub fn run(data: &[u8]) -> Result<(), FileError> {
    run_poses(data, 0..KINDS)
}

/// Loads any bytes, and evaluates what was accepted over some of the [`poses`](crate::poses::pose).
///
/// # Errors
/// Why the bytes were refused.
pub fn run_poses(data: &[u8], numbers: Range<usize>) -> Result<(), FileError> {
    let model = Model::from_bytes(data)?;
    read(&model);
    evaluate(&model, numbers);
    Ok(())
}

/// Repairs the checksum of any bytes, so that mutations reach behind it, and runs them.
///
/// # Errors
/// Why the file was refused.
pub fn repaired(data: &[u8]) -> Result<(), FileError> {
    let mut file = data.to_vec();
    seal(&mut file);
    run(&file)
}

/// Reads bytes as a recipe that changes a golden file piece by piece, and runs the result.
///
/// # Errors
/// Why the file was refused.
pub fn recipe(data: &[u8]) -> Result<(), FileError> {
    run(&recipe::file(data))
}

pub use crate::abi::calls;
pub use crate::round_trip::round_trip;

/// A target's body; whether it accepted the bytes.
pub type Body = fn(&[u8]) -> bool;

/// Every target by the name of its file in `tests/fuzz/fuzz_targets`.
pub const ALL: [(&str, Body); 6] = [
    ("calls", |data| calls(data).is_ok()),
    ("load", |data| load(data).is_ok()),
    ("run", |data| run(data).is_ok()),
    ("repaired", |data| repaired(data).is_ok()),
    ("recipe", |data| recipe(data).is_ok()),
    ("round_trip", |data| round_trip(data).is_ok()),
];
