//! A folder that appears whole or not at all.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why vectors are not written.
#[derive(Debug, Error)]
pub enum VectorError {
    /// There is something in the folder already.
    #[error("{0} is not empty")]
    NotEmpty(PathBuf),
    /// The file system refuses.
    #[error("{path}: {error}", path = .path.display())]
    Io {
        /// What was written or read.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// The runtime refuses a model of our own.
    #[error("{0}")]
    Evaluation(#[from] crate::backend::Failure),
    /// The description of a case cannot be written.
    #[error("{0}")]
    Json(#[from] serde_json::Error),
}

/// A folder under a name of this process's own until it is finished. Dropped unfinished, it leaves
/// nothing.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    place: PathBuf,
    moved: bool,
}

impl Folder {
    /// Begins a folder.
    ///
    /// # Errors
    /// - [`VectorError::NotEmpty`]
    /// - [`VectorError::Io`]
    pub fn create(place: &Path) -> Result<Self, VectorError> {
        let io = |error| VectorError::Io { path: place.to_owned(), error };
        // A trailing slash would put the part inside.
        let place: PathBuf = std::path::absolute(place).map_err(io)?.components().collect();
        match fs::read_dir(&place).map(|mut entries| entries.next().is_some()) {
            Ok(true) => return Err(VectorError::NotEmpty(place)),
            Ok(false) => {}
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(io(error)),
        }
        let mut path = place.clone().into_os_string();
        path.push(format!(".{}.tmp", std::process::id()));
        let path = PathBuf::from(path);
        if let Some(parent) = place.parent() {
            fs::create_dir_all(parent).map_err(io)?;
        }
        fs::create_dir(&path).map_err(io)?;
        Ok(Self { path, place, moved: false })
    }

    /// Writes a file, in a folder of the folder where its name says so.
    ///
    /// # Errors
    /// [`VectorError::Io`]
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), VectorError> {
        let path = self.path.join(name);
        let written = match path.parent() {
            Some(parent) => fs::create_dir_all(parent),
            None => Ok(()),
        };
        let written = written.and_then(|()| fs::write(&path, bytes));
        written.map_err(|error| VectorError::Io { path, error })
    }

    /// Moves the folder to its place.
    ///
    /// # Errors
    /// [`VectorError::Io`]
    pub fn finish(mut self) -> Result<(), VectorError> {
        let io = |error| VectorError::Io { path: self.place.clone(), error };
        // An empty folder may be there: not every system moves over it.
        match fs::remove_dir(&self.place) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(io(error)),
            _ => {}
        }
        fs::rename(&self.path, &self.place).map_err(io)?;
        self.moved = true;
        Ok(())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if !self.moved {
            // The error that led here is the one to report.
            let _ = fs::remove_dir_all(&self.path);
        }
    }
}
