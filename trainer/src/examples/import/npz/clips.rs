//! The clips of the frames, their rate, and what their source calls the frames.

use std::ops::Range;
use std::path::Path;

use super::runs::{RunKind, read_runs};
use super::sidecar::Sidecar;
use crate::examples::validate::same;
use crate::examples::{Clip, ExamplesError, RATES};
use crate::formats::npz::Archive;

/// Clips, as runs of frames.
pub(super) const CLIPS: RunKind =
    RunKind { what: "clips", names: "clip_names", starts: "clip_starts" };

/// Reads the clips of N frames, and how many play a second where that is said; all frames are one clip where none is
/// named, called as the file.
///
/// # Errors
/// Those of [`read_runs`]; [`ExamplesError::FrameNumber`] for numbers that do not ascend in a clip,
/// [`ExamplesError::Rate`].
pub(super) fn read_clips(
    archive: &mut Archive,
    sidecar: &Sidecar,
    file: &Path,
    frame_len: usize,
) -> Result<(Vec<Clip>, Option<f64>), ExamplesError> {
    let (names, starts) = (sidecar.clip_names.as_ref(), sidecar.clip_starts.as_ref());
    let runs = read_runs(archive, &CLIPS, names, starts, frame_len)?;
    let runs = runs.unwrap_or_else(|| vec![(Clip::name_of(file), 0..frame_len)]);
    let numbers = archive.rows::<i64, 1>("frame_numbers", &[])?.map(|numbers| numbers.data);
    if let Some(numbers) = &numbers {
        same("frames", "vertices", frame_len, "frame_numbers", numbers.len())?;
    }
    let fps = sidecar.fps.map_or_else(|| archive.number("fps"), |fps| Ok(Some(fps)))?;
    if let Some(fps) = fps.filter(|fps| !RATES.contains(fps)) {
        return Err(ExamplesError::Rate { fps });
    }
    let clip = |(name, frames): (String, Range<usize>)| {
        let mut clip = match &numbers {
            None => Clip::regular(name, frames.start, frames.len()),
            Some(numbers) => {
                let numbers = ascending(numbers.as_flattened(), &frames)?;
                Clip::numbered(name, frames.start, numbers)
            }
        };
        if let Some(fps) = fps {
            clip.play_at(fps);
        }
        Ok(clip)
    };
    Ok((runs.into_iter().map(clip).collect::<Result<_, ExamplesError>>()?, fps))
}

/// Gives the numbers of a clip's frames, which must ascend and be such as animation programs have.
fn ascending(numbers: &[i64], frames: &Range<usize>) -> Result<Vec<i64>, ExamplesError> {
    let numbers = &numbers[frames.clone()];
    let mut least = i64::from(i32::MIN);
    for (&found, frame) in numbers.iter().zip(frames.clone()) {
        if found < least || found > i64::from(i32::MAX) {
            return Err(ExamplesError::FrameNumber { frame, found, least });
        }
        least = found + 1;
    }
    Ok(numbers.to_vec())
}
