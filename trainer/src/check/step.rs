//! Tests whether the meshes belong to their frames, or to earlier or later frames, in a whole clip or a part.

use super::finding::{Finding, FrameName, Kind, Place, runs};
use super::thresholds::{SHIFT_FRAMES, SHIFT_RUN, SHIFTED, SHIFTS, VISIBLE};
use crate::envelope::lbs::poses::{Poses, trajectories};
use crate::envelope::lbs::targets::Targets;
use crate::envelope::lbs::weights::{self, BASELINE_INFLUENCES};
use crate::examples::{Clip, Examples, Importance, Split, spread};
use crate::space::beside;

/// Number of vertices in a test.
const VERTICES: usize = 400;

/// Number of frames of a clip in a test.
const FRAMES: usize = 200;

/// Largest number of times that LBS is fitted to the shifted meshes and the shifts are searched again.
const ROUNDS: usize = 5;

/// Reports clips whose meshes are out of step, wholly or partly. Returns the examples with each mesh at its own frame;
/// frames without a mesh become extreme.
///
/// - `left_out`: training frames whose meshes belong to no pose, in order.
pub(super) fn steps(
    examples: &Examples,
    clips: &[Clip],
    left_out: &[usize],
    findings: &mut Vec<Finding>,
) -> Option<Examples> {
    let sample = sample(examples);
    let mut moved = Vec::new();
    for (number, clip) in clips.iter().enumerate() {
        let end = clips.get(number + 1).map_or(sample.frame_len(), |next| next.first);
        let of_clip = ClipFrames { sample: &sample, range: clip.first..end, left_out };
        let Some(found) = of_clip.find_shift() else { continue };
        findings.push(found.finding(examples, clips, clip));
        moved.extend((clip.first..end).map(|frame| (frame, of_clip.mesh(frame, found.at(frame)))));
    }
    if moved.is_empty() {
        return None;
    }
    let mut in_step = examples.clone();
    let len = examples.vertex_len();
    for (frame, mesh) in moved {
        match mesh {
            Some(mesh) => {
                in_step.vertices[frame * len..][..len].copy_from_slice(examples.frame(mesh))
            }
            None if examples.split[frame] == Split::Train => in_step.split[frame] = Split::Extreme,
            None => {}
        }
    }
    Some(in_step)
}

/// A clip that is tested for shifts.
struct ClipFrames<'a> {
    sample: &'a Examples,
    /// Frames of the clip.
    range: std::ops::Range<usize>,
    left_out: &'a [usize],
}

/// Frames from `first` on, and the delay of their meshes in frames.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Run {
    first: usize,
    shift: isize,
}

/// The shifts of a clip.
struct Shifted {
    /// Runs of frames in order; neighbouring runs have different shifts.
    runs: Vec<Run>,
    /// RMS error of LBS, with the given meshes and with the meshes in step, in units of the input.
    lbs_errors: [f64; 2],
}

impl ClipFrames<'_> {
    /// Returns the training frame that holds the mesh of a frame whose meshes are `shift` frames late; `None` if the
    /// clip has no such frame.
    fn mesh(&self, frame: usize, shift: isize) -> Option<usize> {
        let mesh = frame.checked_add_signed(shift)?;
        let trains = |frame| self.sample.split[frame] == Split::Train;
        (self.range.contains(&mesh) && trains(frame) && trains(mesh)).then_some(mesh)
    }

    fn find_shift(&self) -> Option<Shifted> {
        let is_seen = |frame: &usize| {
            self.mesh(*frame, 0).is_some() && self.left_out.binary_search(frame).is_err()
        };
        let frames: Vec<usize> = self.range.clone().filter(is_seen).collect();
        let frames: Vec<usize> =
            spread(frames.len(), FRAMES).into_iter().map(|k| frames[k]).collect();
        let whole = |shift| vec![shift; frames.len()];
        if self.lbs_errors(&frames, &whole(0))?[0] < VISIBLE * self.sample.diagonal() {
            return None;
        }
        // The search starts from no shift, one frame late or one frame early for the whole clip.
        let starts = [0, 1, -1].map(|shift| (self.lbs_errors(&frames, &whole(shift)), shift));
        let start = starts.into_iter().filter_map(|(lbs_errors, shift)| Some((lbs_errors?, shift)));
        let (_, start) = start.min_by(|a, b| (a.0[1] / a.0[0]).total_cmp(&(b.0[1] / b.0[0])))?;
        let mut shifts = whole(start);
        for _ in 0..ROUNDS {
            let found = self.shifts(&frames, &shifts)?;
            if found == shifts {
                break;
            }
            shifts = found;
        }
        let lbs_errors @ [now, then] = self.lbs_errors(&frames, &shifts)?;
        (then < SHIFTED * now).then(|| Shifted { runs: shift_runs(&frames, &shifts), lbs_errors })
    }

    /// Fits LBS to the given meshes and to the shifted meshes. Returns both RMS errors, over the frames with both
    /// meshes; `None` for too few frames.
    fn lbs_errors(&self, frames: &[usize], shifts: &[isize]) -> Option<[f64; 2]> {
        let (frames, meshes) = self.pairs(frames, shifts)?;
        let poses = Poses::new(self.sample, &frames);
        Some([&frames, &meshes].map(|meshes| error(self.sample, meshes, &poses)))
    }

    /// Lists the frames that have a mesh after the shift, and their meshes; `None` for too few frames.
    fn pairs(&self, frames: &[usize], shifts: &[isize]) -> Option<(Vec<usize>, Vec<usize>)> {
        let pair = |(&frame, &shift)| Some((frame, self.mesh(frame, shift)?));
        let pairs: (Vec<usize>, Vec<usize>) = frames.iter().zip(shifts).filter_map(pair).unzip();
        (pairs.0.len() >= SHIFT_FRAMES).then_some(pairs)
    }

    /// Finds the delay of each mesh in frames, by LBS fitted to the meshes with the given shifts. A change of the shift
    /// costs [`SHIFT_RUN`] frames of mean error.
    fn shifts(&self, frames: &[usize], shifts: &[isize]) -> Option<Vec<isize>> {
        let (fitted, meshes) = self.pairs(frames, shifts)?;
        let fitted = Poses::new(self.sample, &fitted);
        let shifted = trajectories(self.sample, &meshes, &fitted);
        let rest = &self.sample.rest;
        let (weights, _) = weights::fit(rest, &shifted, &fitted, BASELINE_INFLUENCES, None);
        let poses = Poses::new(self.sample, frames);
        let maps = poses.stacked();
        let errors_of = |shift: isize| -> Vec<f64> {
            let mesh = |&frame: &usize| self.mesh(frame, shift).unwrap_or(frame);
            let meshes: Vec<usize> = frames.iter().map(mesh).collect();
            let trajectories = &trajectories(self.sample, &meshes, &poses);
            let targets =
                Targets { rest, weights: &weights, trajectories, importance: Importance::UNIFORM };
            let left = targets.residuals(&maps);
            let mut errors = vec![0.0; frames.len()];
            for vertex in 0..rest.len() {
                for (error, x) in errors.iter_mut().zip(left.col_as_slice(vertex).chunks(3)) {
                    *error += x.iter().map(|x| x * x).sum::<f64>();
                }
            }
            errors
        };
        // No shift is first, so it wins a tie.
        let tried: Vec<isize> =
            std::iter::once(0).chain((1..=SHIFTS).flat_map(|s| [s, -s])).collect();
        let errors: Vec<Vec<f64>> = tried.iter().map(|&shift| errors_of(shift)).collect();
        let change = SHIFT_RUN * errors[0].iter().sum::<f64>() / frames.len() as f64;
        Some(cheapest(&errors, change).into_iter().map(|k| tried[k]).collect())
    }
}

/// Chooses a row for each column. Minimises the sum of the entries plus `change` for each change of the row.
fn cheapest(rows: &[Vec<f64>], change: f64) -> Vec<usize> {
    let mut costs = vec![0.0; rows.len()];
    let mut from = Vec::new();
    let least = |costs: &[f64]| {
        (0..costs.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).unwrap_or(0)
    };
    for column in 0..rows.first().map_or(0, Vec::len) {
        let best = least(&costs);
        let changed = costs[best] + change;
        let choose = |(k, &cost): (usize, &f64)| if cost < changed { k } else { best };
        from.push(costs.iter().enumerate().map(choose).collect::<Vec<_>>());
        for (cost, row) in costs.iter_mut().zip(rows) {
            *cost = cost.min(changed) + row[column];
        }
    }
    let mut row = least(&costs);
    let mut rows = vec![0; from.len()];
    for (at, from) in rows.iter_mut().zip(&from).rev() {
        *at = row;
        row = from[row];
    }
    rows
}

/// Groups frames into runs with the same shift.
fn shift_runs(frames: &[usize], shifts: &[isize]) -> Vec<Run> {
    let all: Vec<Run> =
        frames.iter().zip(shifts).map(|(&first, &shift)| Run { first, shift }).collect();
    all.chunk_by(|a, b| a.shift == b.shift).map(|run| run[0]).collect()
}

impl Shifted {
    /// Returns the delay of a frame's mesh, in frames.
    fn at(&self, frame: usize) -> isize {
        let run = self.runs.iter().rev().find(|run| run.first <= frame);
        run.or(self.runs.first()).map_or(0, |run| run.shift)
    }

    fn finding(&self, examples: &Examples, clips: &[Clip], clip: &Clip) -> Finding {
        let end = clip.first + clip.times.len();
        let name = |frame| FrameName::new(clips, frame);
        let ends = self.runs.iter().skip(1).map(|run| run.first).chain([end]);
        let late = self.runs.iter().zip(ends).filter(|(run, _)| run.shift != 0);
        let parts: Vec<String> = late
            .clone()
            .map(|(run, end)| {
                let frames: Vec<FrameName> = (run.first..end).map(name).collect();
                let frames = match self.runs.len() {
                    1 => String::new(),
                    _ => format!(" in the frames {}", runs(&frames).join(", ")),
                };
                let late = if run.shift > 0 { "late" } else { "early" };
                match run.shift.unsigned_abs() {
                    1 => format!("one frame {late}{frames}"),
                    count => format!("{count} frames {late}{frames}"),
                }
            })
            .collect();
        let diagonal = examples.diagonal();
        let [now, then] = self.lbs_errors.map(|left| {
            let percent = 100.0 * left / diagonal;
            format!("{percent:.3} %{} of the diagonal", beside(percent, examples.diagonal_mm()))
        });
        let text = format!(
            "the meshes of clip {} seem to be {}: the error of LBS is {now}, and {then} with each mesh moved to its own \
             frame; the rest of this check uses the moved meshes: export them in step",
            clip.name,
            parts.join(", and ")
        );
        let places = late.map(|(run, _)| Place::Frame(name(run.first))).collect();
        Finding::warning(Kind::OutOfStep, text, places)
    }
}

/// Returns the RMS error of LBS fitted to the poses with the meshes of these frames.
pub(super) fn error(sample: &Examples, meshes: &[usize], poses: &Poses) -> f64 {
    let trajectories = trajectories(sample, meshes, poses);
    let (_, errors) = weights::fit(&sample.rest, &trajectories, poses, BASELINE_INFLUENCES, None);
    (errors.iter().sum::<f64>() / (errors.len() * meshes.len()) as f64).sqrt()
}

/// Returns the examples with [`VERTICES`] vertices.
pub(super) fn sample(examples: &Examples) -> Examples {
    let kept = spread(examples.vertex_len(), VERTICES);
    let pick = |points: &[[f64; 3]]| kept.iter().map(|&v| points[v]).collect::<Vec<_>>();
    Examples {
        rest: pick(&examples.rest),
        skeleton: examples.skeleton.clone(),
        vertices: (0..examples.frame_len()).flat_map(|f| pick(examples.frame(f))).collect(),
        transforms: examples.transforms.clone(),
        split: examples.split.clone(),
        clip_starts: examples.clip_starts.clone(),
        ..Examples::default()
    }
}
