//! Frames whose meshes do not belong to their poses: a simulation that exploded, a mesh that is moved or a frame late.
//!
//! Each frame is predicted by all others from its pose, and its error is measured against what the prediction is
//! unsure of: a pose like no other may be predicted badly, up to what skinning errs by there, one among others may not. A frame that is an order of
//! magnitude worse than is usual spoils the prediction of its neighbours too, so the worst is taken out, and the rest
//! looked at anew.

use super::region::{Region, regions};
use crate::envelope::skin::residuals::Residuals;
use crate::envelope::skin::training::Training;

/// How many times a frame's error is what is usual.
const TIMES: f64 = 10.0;
/// How many times farther from all others a pose stands alone than nine of ten do, and how many times larger than theirs,
/// as LBS leaves it, the error of such a pose may be: of it the others tell little.
const ALONE: f64 = 3.0;
/// Share of the frames that others are compared with.
const MOST_FRAMES: f64 = 0.9;
/// Share of the RMS error of LBS below which an error spoils nothing.
const SHARE: f64 = 0.3;
/// Share of the frames beyond which they are no exceptions.
const MOST: f64 = 0.1;
/// Most frames that are compared at once: the work grows with their cube.
const FRAMES: usize = 300;

/// A frame whose mesh does not belong to its pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Broken {
    /// Its number among the training poses.
    pub pose: usize,
    /// How many times its error is what is usual, both over what the prediction is unsure of.
    pub times: f64,
}

/// Finds the training frames whose meshes do not belong to their poses, the worst first; none where there are many.
pub fn broken(training: &Training) -> Vec<Broken> {
    let (left, dominant) = training.left_by_lbs();
    let residuals = Residuals { training, left: &left, dominant: &dominant };
    let n = training.poses.len();
    let parts = n.div_ceil(FRAMES);
    let mut found = Vec::new();
    for part in 0..parts {
        let poses: Vec<usize> = (part..n).step_by(parts).collect();
        found.extend(among(residuals, &poses));
    }
    found.sort_by(|a, b| b.times.total_cmp(&a.times));
    if found.len() as f64 > MOST * n as f64 { Vec::new() } else { found }
}

fn among(residuals: Residuals<'_>, poses: &[usize]) -> Vec<Broken> {
    let regions = regions(residuals, poses);
    // Of the skin that the regions look at.
    let lbs: f64 =
        regions.iter().map(|r| (0..poses.len()).map(|i| r.regression.left(i)).sum::<f64>()).sum();
    let visible = SHARE.powi(2) * lbs / poses.len().max(1) as f64;
    let (mut out, mut found) = (vec![false; poses.len()], Vec::new());
    while found.len() < poses.len() {
        let Some(errors) = surprises(&regions, &out) else { break };
        let mut usual: Vec<f64> = errors.iter().map(|error| error.0).collect();
        let kept: Vec<usize> = (0..poses.len()).filter(|&i| !out[i]).collect();
        let middle = usual.len() / 2;
        let usual = *usual.select_nth_unstable_by(middle, f64::total_cmp).1;
        let worst = (0..kept.len()).max_by(|&a, &b| errors[a].0.total_cmp(&errors[b].0));
        let Some(worst) = worst else { break };
        let (surprise, squared) = errors[worst];
        let times = (surprise / usual.max(f64::MIN_POSITIVE)).sqrt();
        if times < TIMES || squared < visible || may_be(&regions, &kept, worst, squared) {
            break;
        }
        out[kept[worst]] = true;
        found.push(Broken { pose: poses[kept[worst]], times });
    }
    found
}

/// Whether a pose stands alone, and its squared error is no larger than what LBS leaves of others.
fn may_be(regions: &[Region], kept: &[usize], worst: usize, squared: f64) -> bool {
    let mut apart = vec![0.0; kept.len()];
    for region in regions {
        apart.iter_mut().zip(region.regression.apart(kept)).for_each(|(sum, own)| *sum += own);
    }
    let left = |&i: &usize| regions.iter().map(|r| r.regression.left(i)).sum::<f64>();
    let others = kept.iter().enumerate().filter(|(place, _)| *place != worst);
    let left: Vec<f64> = others.map(|(_, i)| left(i)).collect();
    let is_alone = apart[worst] > ALONE.powi(2) * most(apart.clone());
    is_alone && squared < ALONE.powi(2) * most(left)
}

/// What most of some values do not exceed.
fn most(mut values: Vec<f64>) -> f64 {
    let place = (MOST_FRAMES * values.len() as f64) as usize;
    if place < values.len() { *values.select_nth_unstable_by(place, f64::total_cmp).1 } else { 0.0 }
}

/// The squared errors of the frames that are not out, over their variance, and as they are.
fn surprises(regions: &[Region], out: &[bool]) -> Option<Vec<(f64, f64)>> {
    let kept: Vec<usize> = (0..out.len()).filter(|&i| !out[i]).collect();
    let mut sums = vec![(0.0, 0.0); kept.len()];
    for region in regions {
        for (sum, own) in sums.iter_mut().zip(region.regression.surprises(&kept)?) {
            *sum = (sum.0 + own.0, sum.1 + own.1);
        }
    }
    Some(sums)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::demo::{DemoOptions, demo};
    use crate::envelope::skin::poses::Poses;
    use crate::examples::{Examples, Split};
    use crate::progress::Silent;

    const FRAME: usize = 17;

    fn examples() -> Examples {
        demo(&DemoOptions { vertices: 300, poses: 60, held_out: 0, seed: 1 })
    }

    fn found(examples: &Examples) -> Vec<usize> {
        let training = Training::new(examples, &Silent).unwrap();
        broken(&training).iter().map(|broken| broken.pose).collect()
    }

    #[test]
    fn sound_frames_are_left_in() {
        for seed in 1..4 {
            let examples = demo(&DemoOptions { vertices: 300, poses: 40, held_out: 0, seed });
            assert!(found(&examples).is_empty());
        }
    }

    #[test]
    fn a_sound_pose_like_no_other_is_left_in() {
        // The frames near rest, and the one that is farthest from it.
        let all = demo(&DemoOptions { vertices: 300, poses: 80, held_out: 0, seed: 2 });
        let frames: Vec<usize> = (0..80).collect();
        let poses = Poses::new(&all, &frames);
        let bent = |&frame: &usize| -> f64 {
            (0..all.joint_len()).map(|joint| poses.angle(frame, joint).norm_squared()).sum()
        };
        let mut order = frames;
        order.sort_by(|a, b| bent(a).total_cmp(&bent(b)));
        let mut apart = all.clone();
        apart.split.fill(Split::HeldOut);
        order[..40].iter().chain(&order[79..]).for_each(|&i| apart.split[i] = Split::Train);
        assert!(found(&apart).is_empty());
    }

    #[test]
    fn meshes_that_are_moved_exploded_or_late_are_found() {
        let (sound, len) = (examples(), examples().vertex_len());
        let own = FRAME * len..(FRAME + 1) * len;
        let mut moved = sound.clone();
        moved.vertices[own.clone()].iter_mut().for_each(|x| x[1] += 0.2 * sound.diagonal());
        assert_eq!(found(&moved), [FRAME]);
        let mut exploded = sound.clone();
        for (i, x) in exploded.vertices[own.clone()].iter_mut().enumerate() {
            let noise = |k: usize| (12.9898 * (3 * i + k) as f64).sin();
            (0..3).for_each(|k| x[k] += 0.07 * sound.diagonal() * noise(k));
        }
        assert_eq!(found(&exploded), [FRAME]);
        let mut late = sound.clone();
        late.vertices.copy_within((FRAME - 1) * len..FRAME * len, FRAME * len);
        assert_eq!(found(&late), [FRAME]);
    }
}
