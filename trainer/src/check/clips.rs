//! Whether the clips go together: LBS fitted to each alone tells one whose meshes are not of its joints, and LBS fitted to
//! all tells clips in which not the same vertices follow the same joints.

use super::convention::{self, Convention};
use super::finding::{Finding, FrameName, Kind, Place, Severity, listed};
use super::step::{error, sample};
use super::thresholds::{UNLIKE_CLIPS, WRONG_CLIP};
use crate::envelope::lbs::poses::Poses;
use crate::examples::{Clip, Examples, Split, spread};
use crate::space::beside;

/// Fewest training frames of a clip that is looked at: fewer, almost any weights fit.
const FEWEST: usize = 6;
/// Most that are looked at: more tell no more.
const MOST: usize = 200;

/// What LBS leaves of a clip.
struct Fit<'a> {
    clip: &'a Clip,
    /// Training frames that are looked at.
    frames: Vec<usize>,
    /// RMS in diagonals, by weights that are fitted to it alone.
    alone: f64,
}

/// Tells of clips whose meshes are not of their joints, and of clips that no weights fit together. Frames that are
/// doubted tell nothing, but where most of a clip's are.
pub(super) fn clips(examples: &Examples, clips: &[Clip], doubted: &[usize]) -> Vec<Finding> {
    if clips.len() < 2 {
        return Vec::new();
    }
    let sample = sample(examples);
    let rms = |frames: &[usize]| {
        error(&sample, frames, &Poses::new(&sample, frames)) / examples.diagonal()
    };
    let fit = |clip| {
        let frames = frames_of(examples, clip, doubted);
        (frames.len() >= FEWEST).then(|| Fit { clip, alone: rms(&frames), frames })
    };
    let fits: Vec<Fit<'_>> = clips.iter().filter_map(fit).collect();
    let best = fits.iter().map(|fit| fit.alone).fold(f64::INFINITY, f64::min);
    let (least, times) = WRONG_CLIP;
    let is_wrong = |fit: &&Fit<'_>| fit.alone > least.max(times * best);
    let wrong: Vec<&Fit<'_>> = fits.iter().filter(is_wrong).collect();
    let place = |fit: &Fit<'_>| Place::Frame(FrameName::new(clips, fit.clip.first));
    if !wrong.is_empty() {
        return by_remedy(examples, wrong)
            .into_iter()
            .map(|same| same.finding(best, place))
            .collect();
    }
    let all: Vec<usize> = fits.iter().flat_map(|fit| fit.frames.iter().copied()).collect();
    let squared = |rms: f64, frames: usize| frames as f64 * rms * rms;
    let each: f64 = fits.iter().map(|fit| squared(fit.alone, fit.frames.len())).sum();
    let (least, times) = UNLIKE_CLIPS;
    let together = if fits.len() < 2 { 0.0 } else { rms(&all) };
    if together < least || squared(together, all.len()) < times.powi(2) * each {
        return Vec::new();
    }
    let line = |fit: &Fit<'_>| format!("{:.2} % in {}", 100.0 * fit.alone, fit.clip.name);
    vec![Finding {
        kind: Kind::UnlikeClips,
        severity: Severity::Warning,
        text: format!(
            "no weights fit all clips: LBS is off by {:.2} % of the diagonal{} with one set of them, and with one for each by {}; \
             as if joints or vertices had another order in some",
            100.0 * together,
            beside(100.0 * together, examples.diagonal_mm()),
            listed(fits.iter().map(line))
        ),
        places: fits.iter().map(place).collect(),
    }]
}

/// The training frames of a clip that are looked at.
fn frames_of(examples: &Examples, clip: &Clip, doubted: &[usize]) -> Vec<usize> {
    let all = clip.first..clip.first + clip.times.len();
    let all: Vec<usize> = all.filter(|&frame| examples.split[frame] == Split::Train).collect();
    let sound: Vec<usize> = all.iter().copied().filter(|frame| !doubted.contains(frame)).collect();
    let own = if 2 * sound.len() < all.len() { all } else { sound };
    spread(own.len(), MOST).into_iter().map(|k| own[k]).collect()
}

/// Wrong clips that the same would put right, or nothing.
struct Same<'a, 'b> {
    remedy: Option<Convention>,
    clips: Vec<&'a Fit<'b>>,
}

/// What a remedy says should be otherwise, by however much that leaves.
fn what(remedy: &Option<Convention>) -> Option<&str> {
    remedy.as_ref().map(|remedy| remedy.what.as_str())
}

fn by_remedy<'a, 'b>(examples: &Examples, wrong: Vec<&'a Fit<'b>>) -> Vec<Same<'a, 'b>> {
    let mut all = Vec::<Same<'_, '_>>::new();
    for fit in wrong {
        let remedy = convention::of_clip(examples, &fit.frames);
        match all.iter_mut().find(|same| what(&same.remedy) == what(&remedy)) {
            Some(same) => same.clips.push(fit),
            None => all.push(Same { remedy, clips: vec![fit] }),
        }
    }
    all
}

impl Same<'_, '_> {
    fn finding(self, best: f64, place: impl Fn(&Fit<'_>) -> Place) -> Finding {
        let clips = if self.clips.len() == 1 { "clip" } else { "clips" };
        let names = listed(self.clips.iter().map(|fit| fit.clip.name.clone()));
        let places = self.clips.iter().map(|fit| place(fit)).collect();
        if let Some(remedy) = self.remedy {
            return Finding { places, ..remedy.finding(&format!("in {clips} {names}, ")) };
        }
        let worst = self.clips.iter().map(|fit| fit.alone).fold(0.0, f64::max);
        Finding {
            kind: Kind::WrongClip,
            severity: Severity::Warning,
            text: format!(
                "the meshes of {clips} {names} are not of the joints: LBS that is fitted to one alone errs by {:.1} % of the \
                 diagonal, and by {:.2} % in a clip that is right (meshes of another take, at another rate, mirrored, with a \
                 motion that the joints lack, with vertices or joints in another order, or a skin that does there what LBS \
                 cannot): look, and export anew or leave out",
                100.0 * worst,
                100.0 * best
            ),
            places,
        }
    }
}
