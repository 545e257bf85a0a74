//! Pictures one after the other: numbered in a folder, or in one GIF.

use crate::cli::counted;
use crate::cli::files::{OutputFile, write};
use anyhow::{Context, bail};
use sinew_trainer::files;
use sinew_trainer::page::picture::Gif;
use sinew_trainer::page::picture::Picture;
use sinew_trainer::views::player::straight;
use std::path::{Path, PathBuf};

/// Where pictures go.
#[derive(clap::Args)]
pub(super) struct FramesArguments {
    /// The folder to fill with pictures, PNG; or one file, where it ends in .gif, on white
    #[arg(short, long, value_name = "FOLDER|GIF")]
    out: PathBuf,
    /// How long a GIF shows each picture, in seconds: hundredths, from 0.02 on
    #[arg(long, value_name = "SECONDS", default_value = "0.04", value_parser = hundredths)]
    frame_time: u16,
}

/// Pictures on their way to where they go.
pub(super) struct Frames {
    place: Place,
    named: PathBuf,
    count: usize,
}

enum Place {
    Folder,
    Gif { target: OutputFile, pictures: Gif, hundredths: u16 },
}

/// GIF's unit of time, in seconds.
const HUNDREDTH: f64 = 0.01;

fn hundredths(text: &str) -> Result<u16, String> {
    let seconds: f64 = text.parse().map_err(|_| "expected a number of seconds".to_owned())?;
    let hundredths = (seconds / HUNDREDTH).round();
    // Below two hundredths browsers take ten.
    if (2.0..=f64::from(u16::MAX)).contains(&hundredths) {
        Ok(hundredths as u16)
    } else {
        Err("expected 0.02 seconds or more, 655.35 at most".to_owned())
    }
}

impl Frames {
    /// Begins a GIF, or makes the folder; one that is there must hold no pictures of another run.
    ///
    /// - `taken`: what is read, and cannot be written.
    pub(super) fn new(arguments: &FramesArguments, taken: &[PathBuf]) -> anyhow::Result<Self> {
        let FramesArguments { out, frame_time } = arguments;
        let is_gif = out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gif"));
        let place = if is_gif {
            let target = OutputFile::new(out, taken)?;
            Place::Gif { target, pictures: Gif::new(*frame_time), hundredths: *frame_time }
        } else {
            folder(out)?;
            Place::Folder
        };
        Ok(Self { place, named: out.clone(), count: 0 })
    }

    /// Adds the next picture, its colours times their alpha.
    pub(super) fn add(&mut self, picture: &Picture) -> anyhow::Result<()> {
        let picture = straight(picture);
        match &mut self.place {
            Place::Folder => {
                let path = self.named.join(name(self.count));
                files::write(&path, &picture.png()?)
                    .with_context(|| format!("cannot write {}", path.display()))?;
            }
            Place::Gif { pictures, .. } => {
                pictures.add(&picture).with_context(|| self.named.display().to_string())?;
            }
        }
        self.count += 1;
        Ok(())
    }

    /// Writes what is not written yet.
    ///
    /// Returns what there is now, in words, and as JSON how many pictures and for how long each is shown.
    pub(super) fn finish(self) -> anyhow::Result<(String, serde_json::Value)> {
        let count = counted(self.count, "frame", "frames");
        let named = self.named.display();
        let Place::Gif { target, pictures, hundredths } = self.place else {
            return Ok((format!("{named}: {count}"), serde_json::Value::Null));
        };
        write(&[(&target, &pictures.finish()?)])?;
        let seconds = f64::from(hundredths) * HUNDREDTH;
        Ok((format!("{named}: {count} of {seconds:.2} s"), seconds.into()))
    }

    /// Returns how many there are.
    pub(super) fn count(&self) -> usize {
        self.count
    }
}

fn folder(folder: &Path) -> anyhow::Result<()> {
    let about = || folder.display().to_string();
    std::fs::create_dir_all(folder).with_context(about)?;
    if folder.join(name(0)).exists() {
        bail!("{}: it holds frames already", about());
    }
    Ok(())
}

fn name(number: usize) -> String {
    format!("frame{number:04}.png")
}
