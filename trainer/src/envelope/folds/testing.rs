//! Poses that tests cut into folds.

use crate::envelope::lbs::poses::Poses;
use crate::examples::testing::triangle;

/// Makes clips of the given lengths, in which no pose repeats another.
pub(super) fn moving(clips: &[usize]) -> Poses {
    placed(clips, |pose| pose)
}

/// One clip that plays so many poses several times.
pub(super) fn looped(poses: usize, times: usize) -> Poses {
    placed(&[times * poses], |pose| pose % poses)
}

/// Clips in which a joint takes places that lie far apart, by their numbers.
fn placed(clips: &[usize], number: impl Fn(usize) -> usize) -> Poses {
    let frames: Vec<usize> = (0..clips.iter().sum()).collect();
    let mut examples = triangle(frames.len());
    examples.clip_starts = (0..clips.len()).map(|clip| clips[..clip].iter().sum()).collect();
    for &frame in &frames {
        let map = &mut examples.transforms[2 * frame + 1];
        let place = [0.8192, 0.6711, 0.5497].map(|step| step * number(frame) as f64);
        (0..3).for_each(|axis| map[axis][3] = place[axis].fract());
    }
    Poses::new(&examples, &frames)
}
