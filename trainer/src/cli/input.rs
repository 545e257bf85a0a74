//! Examples as the command line names them.

use super::Output;
use anyhow::Context;
use sinew_trainer::examples::{Examples, Split, hash_file, npz};
use std::path::{Path, PathBuf};

/// Example poses to read.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Example poses: a .npz file, with names and parents in it or in a .json beside it
    examples: PathBuf,
    /// Hold out this share of the frames, in contiguous blocks, instead of the file's own split
    #[arg(long, value_name = "SHARE")]
    hold_out: Option<f64>,
}

/// A file that was read, for the record.
#[derive(serde::Serialize)]
pub(super) struct InputFile {
    file: String,
    sha256: String,
}

impl Arguments {
    /// Loads the examples and tells on standard error what should be known about them.
    pub(super) fn load(&self, output: Output) -> anyhow::Result<Examples> {
        let loaded = npz::load(&self.examples)?;
        let mut examples = loaded.examples;
        if !output.quiet {
            for warning in &loaded.warnings {
                eprintln!("warning: {}: {warning}", self.examples.display());
            }
        }
        if let Some(share) = self.hold_out {
            examples.hold_out(share)?;
        }
        Ok(examples)
    }

    /// Hashes every file that a load reads.
    pub(super) fn hashes(&self) -> anyhow::Result<Vec<InputFile>> {
        [self.examples.clone(), self.examples.with_extension("json")]
            .iter()
            .filter(|file| file.exists())
            .map(|file| {
                let sha256 = hash_file(file).with_context(|| file.display().to_string())?;
                let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
                Ok(InputFile { file: name, sha256 })
            })
            .collect()
    }
}

/// Describes the examples in a line.
pub(super) fn describe(examples: &Examples) -> String {
    let count = |split| examples.frames_of(split).len();
    format!(
        "{} vertices, {} triangles, {} joints; {} training, {} held-out, {} extreme frames",
        examples.vertex_len(),
        examples.triangles.len(),
        examples.joint_len(),
        count(Split::Train),
        count(Split::HeldOut),
        count(Split::Extreme),
    )
}

/// Reads a model file.
pub(super) fn read_model(path: &Path) -> anyhow::Result<Vec<u8>> {
    std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))
}
