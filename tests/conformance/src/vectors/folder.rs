//! A folder that appears whole or not at all.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Reasons why vectors cannot be written.
#[derive(Debug, Error)]
pub enum VectorError {
    /// The folder is not empty.
    #[error("{0} is not empty")]
    NotEmpty(PathBuf),
    /// The file system reports an error.
    #[error("{path}: {error}", path = .path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        error: io::Error,
    },
    /// The runtime refuses one of the vectors' models.
    #[error("{0}")]
    Evaluation(#[from] crate::backend::Failure),
    /// The description of a case cannot be written.
    #[error("{0}")]
    Json(#[from] serde_json::Error),
}

/// A folder that has a temporary name until it is finished. An unfinished folder is removed when
/// dropped.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    place: PathBuf,
    moved: bool,
}

impl Folder {
    /// Makes the folder under its temporary name.
    ///
    /// # Errors
    /// - [`VectorError::NotEmpty`]
    /// - [`VectorError::Io`]
    pub fn create(place: &Path) -> Result<Self, VectorError> {
        let io = |error| VectorError::Io { path: place.to_owned(), error };
        // Removes a trailing slash, which would put the temporary folder inside.
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

    /// Writes a file; a name with slashes makes subfolders.
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

    /// Renames the folder to its final name.
    ///
    /// # Errors
    /// [`VectorError::Io`]
    pub fn finish(mut self) -> Result<(), VectorError> {
        let io = |error| VectorError::Io { path: self.place.clone(), error };
        // Removes an empty folder, because some systems cannot rename over one.
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
            // A second error is ignored: the first one is reported.
            let _ = fs::remove_dir_all(&self.path);
        }
    }
}
