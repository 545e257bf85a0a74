//! Whether the clips go together: LBS fitted to each alone tells one whose meshes are not of its joints, and LBS fitted to
//! all tells clips in which not the same vertices follow the same joints.

use super::convention;
use super::finding::{Finding, FrameName, Kind, Place, Severity, listed};
use super::step::{error, sample};
use super::thresholds::{UNLIKE_CLIPS, WRONG_CLIP};
use crate::envelope::skin::poses::Poses;
use crate::examples::{Clip, Examples, Split};

/// Fewest training frames of a clip that is looked at: fewer, almost any weights fit.
const FEWEST: usize = 6;

/// What LBS leaves of a clip, RMS in diagonals.
struct Fit<'a> {
    clip: &'a Clip,
    /// Its training frames.
    frames: Vec<usize>,
    /// By weights that are fitted to it alone.
    alone: f64,
}

/// Tells of clips whose meshes are not of their joints, and of clips that no weights fit together.
pub(super) fn clips<'a>(examples: &Examples, clips: &'a [Clip]) -> Vec<Finding> {
    let sample = sample(examples);
    let rms = |frames: &[usize]| {
        error(&sample, frames, &Poses::new(&sample, frames), 0) / examples.diagonal()
    };
    let trains = |frame: &usize| examples.split[*frame] == Split::Train;
    let fit = |clip: &'a Clip| {
        let frames: Vec<usize> =
            (clip.first..clip.first + clip.times.len()).filter(trains).collect();
        (frames.len() >= FEWEST).then(|| Fit { clip, alone: rms(&frames), frames })
    };
    let fits: Vec<Fit<'_>> = clips.iter().filter_map(fit).collect();
    if fits.len() < 2 {
        return Vec::new();
    }
    let best = fits.iter().map(|fit| fit.alone).fold(f64::INFINITY, f64::min);
    let (least, times) = WRONG_CLIP;
    let is_wrong = |fit: &&Fit<'_>| fit.alone > least.max(times * best);
    let wrong: Vec<Finding> =
        fits.iter().filter(is_wrong).map(|fit| of_clip(examples, clips, fit, best)).collect();
    if !wrong.is_empty() {
        return wrong;
    }
    let squared = |rms: f64, frames: usize| frames as f64 * rms * rms;
    let each: f64 = fits.iter().map(|fit| squared(fit.alone, fit.frames.len())).sum();
    let all: Vec<usize> = fits.iter().flat_map(|fit| fit.frames.iter().copied()).collect();
    let together = rms(&all);
    let (least, times) = UNLIKE_CLIPS;
    if together < least || squared(together, all.len()) < times.powi(2) * each {
        return Vec::new();
    }
    let line = |fit: &Fit<'_>| format!("{:.2} % in {}", 100.0 * fit.alone, fit.clip.name);
    vec![Finding {
        kind: Kind::UnlikeClips,
        severity: Severity::Warning,
        text: format!(
            "no weights fit all clips: LBS errs by {:.2} % of the diagonal with one set of them, and with one for each by {}; \
             as if joints or vertices had another order in some",
            100.0 * together,
            listed(fits.iter().map(line))
        ),
        places: fits
            .iter()
            .map(|fit| Place::Frame(FrameName::new(clips, fit.clip.first)))
            .collect(),
    }]
}

/// Says of a clip what would put it right, or that nothing does.
fn of_clip(examples: &Examples, clips: &[Clip], fit: &Fit<'_>, best: f64) -> Finding {
    let places = vec![Place::Frame(FrameName::new(clips, fit.clip.first))];
    if let Some(found) = convention::of_clip(examples, &fit.clip.name, &fit.frames) {
        return Finding { places, ..found };
    }
    Finding {
        kind: Kind::WrongClip,
        severity: Severity::Warning,
        text: format!(
            "the meshes of clip {} are not of its joints: LBS that is fitted to it alone errs by {:.1} % of the diagonal, \
             and by {:.2} % in a clip that is right (meshes of another take, at another rate, mirrored, with a motion that \
             the joints lack, or with vertices or joints in another order): export it anew, or leave it out",
            fit.clip.name,
            100.0 * fit.alone,
            100.0 * best
        ),
        places,
    }
}
