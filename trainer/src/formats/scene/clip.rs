//! Runs of frames that play one after another.

use std::path::Path;

/// Frames a second where a source names no times.
const RATE: f64 = 30.0;

/// Consecutive frames of one animation.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// Its name in the source.
    pub name: String,
    /// Its first frame among those of all clips.
    pub first: usize,
    /// When each of its frames plays, in seconds from the beginning of the clip, ascending.
    pub times: Vec<f64>,
}

impl Clip {
    /// Makes the one clip of a file that names none: all frames, at 30 a second.
    pub(crate) fn whole(file: &Path, frame_len: usize) -> Self {
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Self::regular(name, 0, frame_len)
    }

    /// Makes a clip of `frame_len` frames from `first` on, at 30 a second.
    pub(crate) fn regular(name: String, first: usize, frame_len: usize) -> Self {
        Self { name, first, times: (0..frame_len).map(|frame| frame as f64 / RATE).collect() }
    }

    /// Makes a clip from `first` on of frames at these times of its source, ascending.
    pub(in crate::formats) fn at(name: String, first: usize, times: &[f64]) -> Self {
        let begin = times.first().copied().unwrap_or_default();
        Self { name, first, times: times.iter().map(|time| time - begin).collect() }
    }

    /// Says what it is called and how many frames it has.
    pub(crate) fn describe(&self) -> String {
        format!("{}: {}", self.name, self.times.len())
    }
}
