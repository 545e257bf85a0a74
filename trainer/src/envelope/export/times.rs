//! The times of an animation's keys.

use super::error::ExportError;
use crate::examples::Clip;

/// Rounds the times of a clip's frames.
pub(super) fn key_times(clip: &Clip) -> Result<Vec<f32>, ExportError> {
    let name = || clip.name.clone();
    if clip.times.is_empty() {
        return Err(ExportError::NoFrames { clip: format!("clip {} has none", name()) });
    }
    let times: Vec<f32> = clip.times.iter().map(|&time| time as f32).collect();
    let bad = (0..times.len()).find(|&key| {
        let after = key == 0 || times[key] > times[key - 1];
        !(after && times[key] >= 0.0 && times[key].is_finite())
    });
    match bad {
        Some(frame) => Err(ExportError::Times { clip: name(), frame, time: clip.times[frame] }),
        None => Ok(times),
    }
}
