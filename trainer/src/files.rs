//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file that is written beside its place and moved there when it is whole; until then whoever
/// opens the place finds the old content. Dropped unfinished, it leaves nothing.
pub struct PendingFile {
    file: File,
    path: PathBuf,
    place: PathBuf,
    moved: bool,
}

impl PendingFile {
    /// Begins a file, under a name of this process's own.
    ///
    /// # Errors
    /// Any of the file system.
    pub fn create(place: &Path) -> io::Result<Self> {
        let mut path = place.as_os_str().to_owned();
        path.push(format!(".{}.tmp", std::process::id()));
        let path = PathBuf::from(path);
        let file = File::create_new(&path)?;
        Ok(Self { file, path, place: place.to_owned(), moved: false })
    }

    /// What to write to.
    pub fn file(&mut self) -> &mut File {
        &mut self.file
    }

    /// Moves the file to its place.
    ///
    /// # Errors
    /// Any of the file system; the old content is then still there.
    pub fn finish(mut self) -> io::Result<()> {
        self.file.sync_all()?;
        fs::rename(&self.path, &self.place)?;
        self.moved = true;
        Ok(())
    }
}

impl Drop for PendingFile {
    fn drop(&mut self) {
        if !self.moved {
            // The error that led here is the one to report.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Writes a whole file.
///
/// # Errors
/// Any of the file system; the old content is then still there.
pub fn write(place: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut part = PendingFile::create(place)?;
    part.file().write_all(bytes)?;
    part.finish()
}
