//! Whether the meshes belong to their frames, or to those before or after.

use super::context::Context;
use super::finding::{Finding, FrameName, Kind, Place, Severity};
use super::thresholds::{SHIFT_FRAMES, SHIFTED, VISIBLE};
use crate::envelope::skin::poses::{Poses, trajectories};
use crate::envelope::skin::weights::{self, BASELINE_INFLUENCES};
use crate::examples::spread;
use crate::examples::{Examples, Split};
use sinew_runtime::format::Space;

/// Vertices that are looked at.
const VERTICES: usize = 400;

/// The longest clip's frames that are looked at.
const FRAMES: usize = 200;

pub(super) fn steps(context: &Context<'_>, findings: &mut Vec<Finding>) {
    let sample = sample(context.examples);
    for (number, clip) in context.clips.iter().enumerate() {
        let end = context.clips.get(number + 1).map_or(sample.frame_len(), |next| next.first);
        let trains = |frame: usize| sample.split[frame] == Split::Train;
        let between = |&frame: &usize| [frame - 1, frame, frame + 1].into_iter().all(trains);
        let inner: Vec<usize> =
            (clip.first + 1..end.max(1) - 1).filter(between).take(FRAMES).collect();
        if inner.len() < SHIFT_FRAMES {
            continue;
        }
        let poses = Poses::new(&sample, &inner);
        let [late, now, early] = [1, 0, -1].map(|shift| error(&sample, &inner, &poses, shift));
        let (shifted, which, other) =
            if late < early { (late, "late", "after") } else { (early, "early", "before") };
        if now < VISIBLE * sample.diagonal() || shifted > SHIFTED * now {
            continue;
        }
        findings.push(Finding {
            kind: Kind::OutOfStep,
            severity: Severity::Warning,
            text: format!(
                "the meshes of clip {} seem to be one frame {which}: LBS errs by {:.3} % of the \
                 diagonal, and by {:.3} % with the mesh of the frame {other}",
                clip.name,
                100.0 * now / sample.diagonal(),
                100.0 * shifted / sample.diagonal()
            ),
            places: vec![Place::Frame(FrameName::new(context.clips, clip.first))],
        });
    }
}

/// RMS error of LBS fitted to the poses with the meshes of other frames.
pub(super) fn error(sample: &Examples, frames: &[usize], poses: &Poses, shift: isize) -> f64 {
    let frames: Vec<usize> = frames.iter().map(|f| f.saturating_add_signed(shift)).collect();
    let moved = trajectories(sample, &frames, poses);
    let (_, errors) = weights::fit(&sample.rest, &moved, poses, BASELINE_INFLUENCES, None);
    (errors.iter().sum::<f64>() / (errors.len() * frames.len()) as f64).sqrt()
}

/// The examples with few vertices.
pub(super) fn sample(examples: &Examples) -> Examples {
    let kept = spread(examples.vertex_len(), VERTICES);
    let pick = |points: &[[f64; 3]]| kept.iter().map(|&v| points[v]).collect::<Vec<_>>();
    Examples {
        rest: pick(&examples.rest),
        triangles: Vec::new(),
        engine: None,
        skeleton: examples.skeleton.clone(),
        vertices: (0..examples.frame_len()).flat_map(|f| pick(examples.frame(f))).collect(),
        transforms: examples.transforms.clone(),
        split: examples.split.clone(),
        ranges: Vec::new(),
        clip_starts: examples.clip_starts.clone(),
        space: Space::default(),
        joint_weights: None,
        importance: None,
        frame_weights: None,
        own_skin: false,
    }
}
