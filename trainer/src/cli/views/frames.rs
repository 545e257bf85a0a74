//! Pictures one after the other: numbered in a folder, or in one GIF.

use crate::cli::counted;
use crate::cli::files::{OutputFile, write};
use anyhow::{Context, bail};
use gif::{Encoder, EncodingError, Frame, Repeat};
use sinew_trainer::files;
use sinew_trainer::page::picture::Picture;
use sinew_trainer::views::player::{on_white, straight};
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
    Gif { target: OutputFile, pictures: Option<Encoder<Vec<u8>>>, hundredths: u16 },
}

/// GIF's unit of time, in seconds.
const HUNDREDTH: f64 = 0.01;
/// What the search for 256 colours passes over: 1 nothing, 30 most.
const COLOUR_SPEED: i32 = 10;

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
            Place::Gif { target, pictures: None, hundredths: *frame_time }
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
            Place::Gif { pictures, hundredths, .. } => {
                add(pictures, *hundredths, &picture)
                    .with_context(|| self.named.display().to_string())?;
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
        let bytes = pictures.map(Encoder::into_inner).transpose()?.unwrap_or_default();
        write(&[(&target, &bytes)])?;
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

fn add(
    pictures: &mut Option<Encoder<Vec<u8>>>,
    hundredths: u16,
    picture: &Picture,
) -> anyhow::Result<()> {
    let size = [picture.size.width, picture.size.height];
    let [Ok(width), Ok(height)] = size.map(u16::try_from) else {
        bail!("pictures of {} x {} pixels, GIF has 65535 at most", size[0], size[1]);
    };
    let mut rgba = on_white(picture).rgba;
    let frame = Frame::from_rgba_speed(width, height, &mut rgba, COLOUR_SPEED);
    let encoder = match pictures.take() {
        Some(encoder) => encoder,
        None => begun(width, height)?,
    };
    pictures.insert(encoder).write_frame(&Frame { delay: hundredths, ..frame })?;
    Ok(())
}

/// Begins a GIF that plays again and again.
fn begun(width: u16, height: u16) -> Result<Encoder<Vec<u8>>, EncodingError> {
    let mut encoder = Encoder::new(Vec::new(), width, height, &[])?;
    encoder.set_repeat(Repeat::Infinite)?;
    Ok(encoder)
}
