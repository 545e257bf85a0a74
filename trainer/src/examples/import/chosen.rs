//! What is asked for, of the frames of all clips.

use crate::examples::Clip;
use crate::formats::scene::Sampling;

/// Chooses the clips that are asked for, one after the other; and the frames that they have among all, where these are
/// not all.
pub(super) fn chosen(clips: Vec<Clip>, sampling: &Sampling<'_>) -> (Vec<Clip>, Option<Vec<usize>>) {
    if clips.iter().all(|clip| sampling.takes(&clip.name)) {
        return (clips, None);
    }
    let mut frames = Vec::new();
    let takes = |clip: &Clip| sampling.takes(&clip.name);
    let taken = clips.into_iter().filter(takes).map(|clip| {
        let first = frames.len();
        frames.extend(clip.first..clip.first + clip.times.len());
        Clip { first, ..clip }
    });
    (taken.collect(), Some(frames))
}

/// Keeps the rows of some frames, `each` a frame; all of them where none are chosen.
pub(super) fn kept<T: Copy>(all: Vec<T>, each: usize, frames: Option<&[usize]>) -> Vec<T> {
    let Some(frames) = frames else { return all };
    frames.iter().flat_map(|&frame| &all[frame * each..][..each]).copied().collect()
}
