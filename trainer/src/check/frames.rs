//! Frames and clips compared with each other: wrong frames, frames of one pose, the order of clips, and clips that do
//! not fit together.
//!
//! LBS is fitted to each clip alone, and to all clips. The first fit shows clips whose meshes do not belong to their
//! joints. The second shows clips in which the same vertices follow different joints.

use super::context::{Context, worst_first};
use super::convention::{self, Convention};
use super::finding::{Finding, FrameName, Kind, LISTED, Place, count, listed, runs};
use super::step::{error, sample};
use super::thresholds::{CONTRADICTION, SAME_POSE, UNLIKE_CLIPS, VISIBLE, WRONG_CLIP};
use crate::envelope::clean::{Inliers, OutlierFrame};
use crate::envelope::lbs::poses::Poses;
use crate::examples::{Clip, Examples, Split, best_order, spread};
use crate::space::beside;

/// Reports frames whose meshes do not belong to their poses, and whether a training leaves them out.
///
/// - `diagonal_mm`: diagonal of the rest mesh in millimetres; `None` if the unit is unknown.
pub(super) fn broken(inliers: &Inliers, clips: &[Clip], diagonal_mm: Option<f64>) -> Finding {
    let Inliers { outliers, keeps_outliers, .. } = inliers;
    let name = |of: &OutlierFrame| FrameName::new(clips, of.frame);
    let line = |of: &OutlierFrame| {
        let mm = beside(of.percent, diagonal_mm);
        let (percent, usual) = (of.percent, of.usual_percent);
        format!("{} (off by {percent:.2} % of the diagonal{mm}, {usual:.2} % is usual)", name(of))
    };
    let names: Vec<FrameName> = outliers.iter().map(name).collect();
    let all = match outliers.len() {
        0..=LISTED => String::new(),
        _ => format!("; all of them: {}", runs(&names).join(", ")),
    };
    let then = match keeps_outliers {
        true => "without them too few frames or no motion would be left, so a training keeps them",
        false => "a training leaves out the frames named here",
    };
    let text = format!(
        "{} a mesh that does not belong to the pose, judged by the other frames (an exploded simulation, a displaced \
         mesh, or the mesh of another frame); {then}: check them, and fix or remove them: frame {}{all}",
        count(outliers.len(), "frame has", "frames have"),
        listed(outliers.iter().map(line))
    );
    Finding::warning(Kind::Broken, text, names.into_iter().map(Place::Frame).collect())
}

/// A training frame with the pose of an earlier frame.
struct Repeat {
    frame: usize,
    first: usize,
    /// RMS difference of the LBS residuals, in diagonals.
    gap: f64,
}

pub(super) fn repeats(context: &Context<'_>, findings: &mut Vec<Finding>) {
    let mut firsts: Vec<usize> = Vec::new();
    let mut repeats = Vec::new();
    for frame in 0..context.frames.len() {
        let with_distance =
            |&first: &usize| (first, context.turns.distance(first, frame, SAME_POSE));
        let nearest = firsts.iter().map(with_distance).min_by(|a, b| a.1.total_cmp(&b.1));
        match nearest.filter(|nearest| nearest.1.is_finite()) {
            Some((first, _)) => {
                repeats.push(Repeat { frame, first, gap: rms_gap(context, first, frame) })
            }
            None => firsts.push(frame),
        }
    }
    let most = VISIBLE.max(CONTRADICTION * context.training.lbs_rms());
    let (contradicting, repeated): (Vec<Repeat>, Vec<Repeat>) =
        repeats.into_iter().partition(|repeat| repeat.gap > most);
    let pair = |repeat: &Repeat| {
        format!("{} as {}", context.frame(repeat.frame), context.frame(repeat.first))
    };
    if !contradicting.is_empty() {
        let order = worst_first(0..contradicting.len(), |k| contradicting[k].gap);
        let line = |&k: &usize| {
            let (vertex, distance) =
                farthest(context, contradicting[k].first, contradicting[k].frame);
            let pair = pair(&contradicting[k]);
            format!("{pair}, {} apart at vertex {vertex}", context.length(distance))
        };
        let text = format!(
            "{} the pose of another frame within {SAME_POSE}° but a different mesh, which no function of \
             the pose can give (dynamics, a simulation that had not settled, or meshes of \
             another frame): {}",
            count(contradicting.len(), "frame has", "frames have"),
            listed(order.iter().map(line))
        );
        let places = order.iter().flat_map(|&k| [contradicting[k].frame, contradicting[k].first]);
        findings.push(Finding::warning(Kind::Contradicting, text, context.frames(places)));
    }
    if !repeated.is_empty() {
        let text = format!(
            "{} the pose and mesh of another, and may be left out: {}",
            count(repeated.len(), "frame repeats", "frames repeat"),
            listed(repeated.iter().map(pair))
        );
        let places = context.frames(repeated.iter().map(|repeat| repeat.frame));
        findings.push(Finding::note(Kind::Repeated, text, places));
    }
}

fn rms_gap(context: &Context<'_>, a: usize, b: usize) -> f64 {
    let sum: f64 = (0..context.dominant.len()).map(|v| squared_gap(context, v, a, b)).sum();
    (sum / context.dominant.len() as f64).sqrt()
}

/// Returns the vertex with the largest difference between the LBS residuals of two frames, and the difference in
/// diagonals.
fn farthest(context: &Context<'_>, a: usize, b: usize) -> (usize, f64) {
    let gaps = (0..context.dominant.len()).map(|v| (v, squared_gap(context, v, a, b).sqrt()));
    gaps.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
}

fn squared_gap(context: &Context<'_>, vertex: usize, a: usize, b: usize) -> f64 {
    let column = context.residuals.col_as_slice(vertex);
    (0..3).map(|axis| (column[3 * a + axis] - column[3 * b + axis]).powi(2)).sum()
}

/// Reports meshes in another order of clips.
pub(super) fn clip_order(examples: &Examples, clips: &[Clip]) -> Option<Finding> {
    let order = best_order(examples, clips, true)?;
    let [other, here] = order.percent;
    let names: Vec<&str> = order.clips.iter().map(|&clip| clips[clip].name.as_str()).collect();
    let text = format!(
        "the meshes fit the clips in another order, {}: vertices are then {other:.2} % of the diagonal from their \
         positions under one joint each, now {here:.2} %",
        names.join(", ")
    );
    let place = |clip: &Clip| Place::Frame(FrameName::new(clips, clip.first));
    Some(Finding::warning(Kind::ClipOrder, text, clips.iter().map(place).collect()))
}

/// Fewest training frames of a clip for a test; almost any weights fit fewer frames.
const FEWEST: usize = 6;
/// Most frames of a clip in a test; more frames add no information.
const MOST: usize = 200;

/// LBS fitted to one clip.
struct Fit<'a> {
    clip: &'a Clip,
    /// The tested training frames.
    frames: Vec<usize>,
    /// RMS error in diagonals.
    alone: f64,
}

/// Reports clips whose meshes do not belong to their joints, and clips that no common weights fit. Wrong frames are
/// skipped, unless most frames of a clip are wrong.
pub(super) fn clips(examples: &Examples, clips: &[Clip], wrong_frames: &[usize]) -> Vec<Finding> {
    if clips.len() < 2 {
        return Vec::new();
    }
    let sample = sample(examples);
    let rms = |frames: &[usize]| {
        error(&sample, frames, &Poses::new(&sample, frames)) / examples.diagonal()
    };
    let fit = |clip| {
        let frames = frames_of(examples, clip, wrong_frames);
        (frames.len() >= FEWEST).then(|| Fit { clip, alone: rms(&frames), frames })
    };
    let fits: Vec<Fit<'_>> = clips.iter().filter_map(fit).collect();
    let best = fits.iter().map(|fit| fit.alone).fold(f64::INFINITY, f64::min);
    let (least, times) = WRONG_CLIP;
    let is_wrong = |fit: &&Fit<'_>| fit.alone > least.max(times * best);
    let wrong: Vec<&Fit<'_>> = fits.iter().filter(is_wrong).collect();
    let place = |fit: &Fit<'_>| Place::Frame(FrameName::new(clips, fit.clip.first));
    if !wrong.is_empty() {
        let groups = group_by_remedy(examples, wrong).into_iter();
        return groups.map(|(remedy, fits)| wrong_clips(remedy, &fits, best, place)).collect();
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
    let text = format!(
        "no weights fit all clips: the error of LBS is {:.2} % of the diagonal{} with one set of weights, and with a set \
         for each clip {}; perhaps joints or vertices have another order in some clips",
        100.0 * together,
        beside(100.0 * together, examples.diagonal_mm()),
        listed(fits.iter().map(line))
    );
    vec![Finding::warning(Kind::UnlikeClips, text, fits.iter().map(place).collect())]
}

/// Returns the tested training frames of a clip.
fn frames_of(examples: &Examples, clip: &Clip, wrong_frames: &[usize]) -> Vec<usize> {
    let all = clip.first..clip.first + clip.times.len();
    let all: Vec<usize> = all.filter(|&frame| examples.split[frame] == Split::Train).collect();
    let sound: Vec<usize> =
        all.iter().copied().filter(|frame| !wrong_frames.contains(frame)).collect();
    let own = if 2 * sound.len() < all.len() { all } else { sound };
    spread(own.len(), MOST).into_iter().map(|k| own[k]).collect()
}

/// Groups wrong clips by the change that their remedy asks for; clips without a remedy are one group.
fn group_by_remedy<'a, 'b>(
    examples: &Examples,
    wrong: Vec<&'a Fit<'b>>,
) -> Vec<(Option<Convention>, Vec<&'a Fit<'b>>)> {
    let mut groups: Vec<(Option<Convention>, Vec<&Fit<'_>>)> = Vec::new();
    for fit in wrong {
        let remedy = convention::of_clip(examples, &fit.frames);
        let change = remedy.as_ref().map(|remedy| &remedy.change);
        match groups.iter_mut().find(|(own, _)| own.as_ref().map(|own| &own.change) == change) {
            Some((_, fits)) => fits.push(fit),
            None => groups.push((remedy, vec![fit])),
        }
    }
    groups
}

/// Reports wrong clips with the same remedy, or without one.
fn wrong_clips(
    remedy: Option<Convention>,
    fits: &[&Fit<'_>],
    best: f64,
    place: impl Fn(&Fit<'_>) -> Place,
) -> Finding {
    let clips = if fits.len() == 1 { "clip" } else { "clips" };
    let names = listed(fits.iter().map(|fit| &fit.clip.name));
    let places = fits.iter().map(|fit| place(fit)).collect();
    if let Some(remedy) = remedy {
        return Finding { places, ..remedy.finding(&format!("in {clips} {names}, ")) };
    }
    let worst = fits.iter().map(|fit| fit.alone).fold(0.0, f64::max);
    let text = format!(
        "the meshes of {clips} {names} do not belong to the joints: LBS fitted to the clip alone has an error of \
         {:.1} % of the diagonal, and {:.2} % in a clip that is right (perhaps the meshes are of another take or \
         rate, mirrored, or have a motion that the joints lack; vertices or joints have another order; or LBS cannot \
         express the skin of this clip): check the clip, and export it again or leave it out",
        100.0 * worst,
        100.0 * best
    );
    Finding::warning(Kind::WrongClip, text, places)
}
