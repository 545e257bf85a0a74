//! Bodies of the fuzz targets. Each body panics at a finding and has no other effect.

use crate::evaluate::{evaluate, read};
use crate::poses::KINDS;
use crate::recipe;
use models::seal;
use sinew_runtime::{FileError, Model};
use std::ops::Range;

/// Loads any bytes, and reads an accepted file.
///
/// # Errors
/// The reason why the bytes were refused.
pub fn load(data: &[u8]) -> Result<(), FileError> {
    Model::from_bytes(data).map(|model| read(&model))
}

/// Loads any bytes, and evaluates an accepted file.
///
/// # Errors
/// The reason why the bytes were refused.
pub fn run(data: &[u8]) -> Result<(), FileError> {
    run_poses(data, 0..KINDS)
}

/// Loads any bytes, and evaluates an accepted file over the [`poses`](crate::poses::pose)
/// `numbers`.
///
/// # Errors
/// The reason why the bytes were refused.
pub fn run_poses(data: &[u8], numbers: Range<usize>) -> Result<(), FileError> {
    let model = Model::from_bytes(data)?;
    read(&model);
    evaluate(&model, numbers);
    Ok(())
}

/// Repairs the checksum of any bytes and runs the file, so that mutations get past the checksum.
///
/// # Errors
/// The reason why the file was refused.
pub fn repaired(data: &[u8]) -> Result<(), FileError> {
    let mut file = data.to_vec();
    seal(&mut file);
    run(&file)
}

/// Reads bytes as a recipe that changes a golden file piece by piece, and runs the result.
///
/// # Errors
/// The reason why the file was refused.
pub fn recipe(data: &[u8]) -> Result<(), FileError> {
    run(&recipe::file(data))
}

pub use crate::abi::calls;
pub use crate::round_trip::round_trip;

/// Body of a target; returns whether the bytes were accepted.
pub type Body = fn(&[u8]) -> bool;

/// Every target, with the name of its file in `tests/fuzz/fuzz_targets`.
pub const ALL: [(&str, Body); 6] = [
    ("calls", |data| calls(data).is_ok()),
    ("load", |data| load(data).is_ok()),
    ("run", |data| run(data).is_ok()),
    ("repaired", |data| repaired(data).is_ok()),
    ("recipe", |data| recipe(data).is_ok()),
    ("round_trip", |data| round_trip(data).is_ok()),
];
