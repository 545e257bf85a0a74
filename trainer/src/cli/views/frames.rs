//! Pictures one after the other, in a folder.

use anyhow::{Context, bail};
use sinew_trainer::files;
use sinew_trainer::page::picture::Picture;
use sinew_trainer::views::player::straight;
use std::path::{Path, PathBuf};

/// A folder that is filled with numbered pictures.
pub(super) struct Frames {
    folder: PathBuf,
    count: usize,
}

impl Frames {
    /// Makes the folder; one that is there must hold no pictures of another run.
    pub(super) fn new(folder: &Path) -> anyhow::Result<Self> {
        let about = || folder.display().to_string();
        std::fs::create_dir_all(folder).with_context(about)?;
        if folder.join(name(0)).exists() {
            bail!("{}: it holds frames already", about());
        }
        Ok(Self { folder: folder.to_owned(), count: 0 })
    }

    /// Writes the next picture, its colours times their alpha.
    pub(super) fn add(&mut self, picture: &Picture) -> anyhow::Result<()> {
        let path = self.folder.join(name(self.count));
        files::write(&path, &straight(picture).png()?)
            .with_context(|| format!("cannot write {}", path.display()))?;
        self.count += 1;
        Ok(())
    }

    /// Returns how many there are.
    pub(super) fn count(&self) -> usize {
        self.count
    }
}

fn name(number: usize) -> String {
    format!("frame{number:04}.png")
}
