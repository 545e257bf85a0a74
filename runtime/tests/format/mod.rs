//! Valid and refused files, and ownership of a file's bytes.

mod changing;
mod content;
mod damage;
mod document;
mod filters;
mod groups;
mod kernels;
mod limits;
mod message;
mod ownership;
mod priors;
mod records;
mod shapes;
mod sound;
mod tables;
mod views;

use models::Pieces;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::{FileError, Model};

fn error(bytes: &[u8]) -> FileError {
    Model::from_bytes(bytes).unwrap_err()
}

/// Loads a sample after `edit`.
fn edited(edit: impl FnOnce(&mut Pieces)) -> Result<(), FileError> {
    let mut pieces = Pieces::small(Predictor::Rotational);
    edit(&mut pieces);
    Model::from_bytes(pieces.bytes()).map(|_| ())
}
