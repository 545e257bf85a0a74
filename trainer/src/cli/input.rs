//! Examples and models as the command line names them.

use super::Output;
use super::bars::Bars;
use anyhow::{Context, bail};
use sinew_trainer::examples::{Clip, Examples, ExamplesError, Split, hash_file, npz};
use std::path::{Path, PathBuf};

/// Example poses to read.
#[derive(clap::Args)]
pub(super) struct ExampleArguments {
    /// Example poses: a .npz file, with names and parents in it or in a .json beside it
    pub(super) examples: PathBuf,
    /// Hold out this share of the frames (0.25 is a quarter), in contiguous blocks, instead of the
    /// file's own split; give `train`, `eval` and `report` the same
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true)]
    pub(super) hold_out: Option<f64>,
}

/// Examples as they were read.
pub(super) struct Input {
    pub(super) examples: Examples,
    /// The clips that its frames come from.
    pub(super) clips: Vec<Clip>,
    /// What was told about them.
    pub(super) warnings: Vec<String>,
}

/// A file that is read, for the record.
#[derive(serde::Serialize)]
pub(super) struct InputFile {
    file: String,
    sha256: String,
}

impl ExampleArguments {
    /// Loads the examples and tells on standard error what should be known about them.
    pub(super) fn load(&self, output: Output) -> anyhow::Result<Input> {
        self.check()?;
        let reading = Bars::busy(output, "reading examples");
        let loaded = npz::load(&self.examples)?;
        drop(reading);
        let mut examples = loaded.examples;
        let warnings: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
        for warning in &warnings {
            output.warn(self.examples.display(), warning);
        }
        if let Some(share) = self.hold_out {
            examples.hold_out(share).with_context(|| self.examples.display().to_string())?;
        }
        Ok(Input { examples, clips: loaded.clips, warnings })
    }

    /// Hashes every file that a load reads.
    pub(super) fn hashes(&self) -> anyhow::Result<Vec<InputFile>> {
        self.check()?;
        self.files()
            .iter()
            .filter(|file| file.exists())
            .map(|file| {
                let sha256 = hash_file(file).with_context(|| file.display().to_string())?;
                let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
                Ok(InputFile { file: name, sha256 })
            })
            .collect()
    }

    /// Names every file that a load reads, where it is there.
    pub(super) fn files(&self) -> [PathBuf; 2] {
        [self.examples.clone(), self.examples.with_extension("json")]
    }

    /// Refuses what is easily given by mistake.
    fn check(&self) -> anyhow::Result<()> {
        let path = self.examples.display();
        if self.examples.is_dir() {
            bail!("{path}: is a folder, expected a .npz file");
        }
        if self.examples.extension().is_some_and(|extension| extension == "json") {
            bail!("{path}: describes examples, expected the .npz file beside it");
        }
        Ok(())
    }
}

/// Parses a share of the frames.
fn share(text: &str) -> Result<f64, String> {
    let share: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    if share > 0.0 && share < 1.0 {
        return Ok(share);
    }
    Err(ExamplesError::BadShare { share }.to_string())
}

/// Describes the examples in a line.
pub(super) fn describe(examples: &Examples) -> String {
    format!(
        "{} vertices, {} triangles, {} joints; {}",
        examples.vertex_len(),
        examples.triangles.len(),
        examples.joint_len(),
        describe_frames(examples)
    )
}

/// Counts the frames by use.
pub(super) fn describe_frames(examples: &Examples) -> String {
    let count = |split| examples.frames_of(split).len();
    format!(
        "{} training, {} held-out, {} extreme frames",
        count(Split::Train),
        count(Split::HeldOut),
        count(Split::Extreme),
    )
}

/// Reads a model file.
pub(super) fn read_model(path: &Path) -> anyhow::Result<Vec<u8>> {
    let cannot_read = || format!("cannot read {}", path.display());
    let kind = std::fs::metadata(path).with_context(cannot_read)?;
    if !kind.is_file() {
        // A device may never end.
        bail!("{}: it is {}", cannot_read(), if kind.is_dir() { "a folder" } else { "no file" });
    }
    std::fs::read(path).with_context(cannot_read)
}
