//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file under construction, written next to its destination and moved there once complete.
///
/// Until then the destination keeps its old content. Dropping an unfinished file removes it.
pub struct PendingFile {
    /// The file to write to.
    pub file: File,
    path: PathBuf,
    destination: PathBuf,
    finished: bool,
}

impl PendingFile {
    /// Creates the file, under a name that only this process uses.
    ///
    /// # Errors
    /// Any error of the file system.
    pub fn create(destination: &Path) -> io::Result<Self> {
        let mut path = destination.as_os_str().to_owned();
        path.push(format!(".{}.tmp", std::process::id()));
        let path = PathBuf::from(path);
        let file = File::create_new(&path)?;
        Ok(Self { file, path, destination: destination.to_owned(), finished: false })
    }

    /// Moves the file to its destination.
    ///
    /// # Errors
    /// Any error of the file system; the destination then keeps its old content.
    pub fn finish(mut self) -> io::Result<()> {
        self.file.sync_all()?;
        fs::rename(&self.path, &self.destination)?;
        self.finished = true;
        Ok(())
    }
}

impl Drop for PendingFile {
    fn drop(&mut self) {
        if !self.finished {
            // Whatever error led here is reported instead.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Writes a whole file.
///
/// # Errors
/// Any error of the file system; the old content then remains.
pub fn write(destination: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut part = PendingFile::create(destination)?;
    part.file.write_all(bytes)?;
    part.finish()
}
