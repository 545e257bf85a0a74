//! What can be wrong with a file, whatever its format.

use super::abc::AlembicError;
use super::csv::CsvError;
use super::layered::LayeredError;
use super::npz::ArrayError;
use super::obj::ObjError;
use super::posed_meshes::{PointCacheError, SequenceError};
use super::scene::SceneError;
use std::path::PathBuf;

/// A file that cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {error}", file.display())]
pub struct FileError {
    /// The file at fault.
    pub file: PathBuf,
    /// What is wrong with it.
    pub error: FormatError,
}

/// What is wrong with a file.
#[derive(Debug, thiserror::Error)]
pub enum FormatError {
    /// The file cannot be opened or read.
    #[error("cannot be read: {0}")]
    Read(std::io::Error),
    /// The file cannot be written.
    #[error("cannot be written: {0}")]
    Write(std::io::Error),
    /// The file's name does not end as any format that is read here.
    #[error("expected a file that ends in {expected}, found {found}")]
    UnknownFormat {
        /// The endings that are read.
        expected: &'static str,
        /// The ending found.
        found: String,
    },
    /// The file is of a format that is not read.
    #[error("is {format}, which is not read: {remedy}")]
    Unread {
        /// The format.
        format: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// There is nothing in the file.
    #[error("is empty")]
    Empty,
    /// The file is a baked model, where examples are read.
    #[error("is a baked model, expected examples: commands take the model first")]
    Model,
    /// The file holds what another ending stands for.
    #[error("holds what a .{ending} file holds: give it that ending")]
    OtherContent {
        /// The ending of what it holds.
        ending: &'static str,
    },
    /// A scene is damaged, or lacks what a rigged character has.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Arrays are missing, damaged or others than expected.
    #[error(transparent)]
    Array(#[from] ArrayError),
    /// A point cache is damaged or none.
    #[error(transparent)]
    PointCache(#[from] PointCacheError),
    /// An Alembic archive is damaged, or its meshes are not of one mesh.
    #[error(transparent)]
    Alembic(#[from] AlembicError),
    /// Meshes do not follow one another.
    #[error(transparent)]
    Sequence(#[from] SequenceError),
    /// The file is no OBJ, or a folder of them is not a face.
    #[error(transparent)]
    Obj(#[from] ObjError),
    /// The file is no picture in layers, or lacks a layer.
    #[error(transparent)]
    Layered(#[from] LayeredError),
    /// The file is no table of numbers.
    #[error(transparent)]
    Csv(#[from] CsvError),
}
