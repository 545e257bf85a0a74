//! Sample times of a clip for playback: linear keys at these times reproduce the clip.

use super::clip::{SAME_TIME, Sample, Sampling, sample_times};
use crate::Error;
use crate::numeric::so3::polar;
use nalgebra::{Matrix3, Matrix4, Rotation3, UnitQuaternion, Vector3};
use rayon::prelude::*;

/// Largest error of the joints between two samples, over the skeleton's size; a larger step is a jump. Skins must stay
/// within 1e-3 of their diagonal.
const NEAR: f64 = 2e-4;
/// Number of times that the step between two keys may be halved.
const HALVINGS: u32 = 10;
/// Largest step, in frames of a baked file, that is not subdivided: the file does not define the motion between its
/// frames.
const FRAMES: f64 = 1.5;
/// Places between two samples at which linear interpolation is compared with the clip.
const PARTS: [f64; 3] = [0.25, 0.5, 0.75];

/// World frames of the joints.
pub(in crate::formats) type Pose = Vec<Matrix4<f64>>;

/// The joints that a clip moves.
pub(in crate::formats) struct MovingJoints<'a, F> {
    /// Parent of each joint.
    pub(in crate::formats) parents: &'a [Option<usize>],
    /// Seconds of a frame in a file of baked frames, whose steps are not halved further; 0 for other files.
    pub(in crate::formats) frame: f64,
    /// Returns the world frames of the joints at a time in seconds.
    pub(in crate::formats) pose: F,
}

/// Chooses the moments at which the clip `name` is sampled.
///
/// For training a clip has one sample a key, or the rate that is asked for. For playback a jump has two samples, whose
/// times are neighbours in single precision. Curves get more samples between their keys, unless a rate is given.
///
/// - `keys`: key times of every channel, in any order, in seconds.
///
/// # Errors
/// The keys are not finite or too far apart, or a pose cannot be computed.
pub(in crate::formats) fn samples(
    name: &str,
    keys: Vec<f64>,
    sampling: &Sampling<'_>,
    joints: &MovingJoints<'_, impl Fn(f64) -> Result<Pose, Error> + Sync>,
) -> Result<Vec<Sample>, Error> {
    let MovingJoints { parents, frame, pose } = joints;
    let times = sample_times(name, keys.clone(), sampling)?;
    if !sampling.played || times.is_empty() {
        return Ok(times.into_iter().map(|time| Sample { at: time, time }).collect());
    }
    let wanted = sampling.fps.map(|_| times);
    let moments = moments(keys, wanted.as_deref());
    let reached = |moment: &Moment| Ok([pose(moment.first.next_down())?, pose(moment.last)?]);
    let reached = moments.par_iter().map(reached).collect::<Result<Vec<_>, Error>>()?;
    let measure = Measure::new(parents, *frame, reached.iter().map(|[_, after]| after));
    let mut kept = Vec::new();
    for (moment, [before, after]) in moments.iter().zip(&reached) {
        let is_jump = !kept.is_empty() && measure.distance(before, after) > NEAR;
        if moment.is_sample || is_jump {
            kept.push((moment, if is_jump { before } else { after }, after, is_jump));
        }
    }
    let between = kept.par_windows(2).map(|pair| match pair {
        [(from, _, start, _), (to, end, ..)] if sampling.fps.is_none() => {
            measure.between([from.last, to.last], [start, end], pose, HALVINGS)
        }
        _ => Ok(Vec::new()),
    });
    let between = between.collect::<Result<Vec<_>, Error>>()?;
    let mut all = Vec::new();
    for (number, &(&Moment { first, last, .. }, _, _, is_jump)) in kept.iter().enumerate() {
        let steps = number.checked_sub(1).and_then(|before| between.get(before));
        all.extend(steps.into_iter().flatten().map(|&time| Sample { at: time, time }));
        if is_jump {
            let time = f64::from((last as f32).next_down());
            all.push(Sample { at: first.next_down(), time });
        }
        all.push(Sample { at: last, time: last });
    }
    Ok(all)
}

/// Keys at nearly one time, or a requested time between keys.
struct Moment {
    first: f64,
    last: f64,
    /// Whether the moment is a sample even without a jump.
    is_sample: bool,
}

/// Merges keys at nearly one time. Every moment is a sample, or only the `wanted` times are.
fn moments(keys: Vec<f64>, wanted: Option<&[f64]>) -> Vec<Moment> {
    let keys = keys.into_iter().map(|key| (key, wanted.is_none()));
    let wanted = wanted.into_iter().flatten().map(|&time| (time, true));
    let mut all: Vec<(f64, bool)> = keys.chain(wanted).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut moments: Vec<Moment> = Vec::new();
    for (time, is_sample) in all {
        match moments.last_mut().filter(|moment| time - moment.first < SAME_TIME) {
            Some(moment) => {
                moment.last = time;
                moment.is_sample |= is_sample;
            }
            None => moments.push(Moment { first: time, last: time, is_sample }),
        }
    }
    moments
}

/// Compares poses of a skeleton.
struct Measure<'a> {
    parents: &'a [Option<usize>],
    /// Joints, parents before children.
    order: Vec<usize>,
    /// Diagonal of the box around the joints.
    size: f64,
    /// Longest step that is never halved.
    least: f64,
}

impl<'a> Measure<'a> {
    fn new(
        parents: &'a [Option<usize>],
        frame: f64,
        poses: impl Iterator<Item = &'a Pose>,
    ) -> Self {
        let depth = |joint: &usize| {
            std::iter::successors(parents[*joint], |&parent| parents[parent]).count()
        };
        let mut order: Vec<usize> = (0..parents.len()).collect();
        order.sort_by_key(depth);
        let poses: Vec<&Pose> = poses.collect();
        let one = extent(poses.first().into_iter().copied());
        // A single joint has no extent, so its path gives the size.
        let size = if one > 0.0 { one } else { extent(poses.into_iter()) };
        let size = if size > 0.0 { size } else { 1.0 };
        Self { parents, order, size, least: FRAMES * frame }
    }

    /// Returns the largest distance between two poses near their joints, over the skeleton's size.
    fn distance(&self, a: &Pose, b: &Pose) -> f64 {
        let joints = a.iter().zip(b).map(|(a, b)| {
            let moved = (a - b).fixed_view::<3, 1>(0, 3).norm() / self.size;
            let [linear, other] = [a, b].map(|m| m.fixed_view::<3, 3>(0, 0).into_owned());
            let own = linear.norm() / 3_f64.sqrt();
            moved + if own > 0.0 { (linear - other).norm() / own } else { 0.0 }
        });
        joints.fold(0.0, f64::max)
    }

    /// Lists the further sample times that linear interpolation needs between two samples.
    fn between(
        &self,
        [from, to]: [f64; 2],
        [start, end]: [&Pose; 2],
        pose: &impl Fn(f64) -> Result<Pose, Error>,
        halvings: u32,
    ) -> Result<Vec<f64>, Error> {
        let middle = 0.5 * (from + to);
        let single = [from, middle, to].map(|time| time as f32);
        let has_room = single[0].next_up() < single[1] && single[1] < single[2].next_down();
        if halvings == 0 || !has_room || to - from <= self.least {
            return Ok(Vec::new());
        }
        let mut is_near = true;
        for part in PARTS {
            let there = pose(from + part * (to - from))?;
            is_near &= self.distance(&there, &self.blended(start, end, part)) <= NEAR;
        }
        if is_near {
            return Ok(Vec::new());
        }
        let here = pose(middle)?;
        let mut all = self.between([from, middle], [start, &here], pose, halvings - 1)?;
        all.push(middle);
        all.extend(self.between([middle, to], [&here, end], pose, halvings - 1)?);
        Ok(all)
    }

    /// Interpolates between two poses as linear keys do, relative to the parent: the origin of a joint moves along a
    /// line, and its axes along an arc.
    fn blended(&self, start: &Pose, end: &Pose, part: f64) -> Pose {
        let mut worlds = vec![Matrix4::identity(); start.len()];
        for &joint in &self.order {
            let local = |pose: &Pose| {
                let back = self.parents[joint].and_then(|parent| pose[parent].try_inverse());
                back.map_or(pose[joint], |back| back * pose[joint])
            };
            let [(a, turn_a, place_a), (b, turn_b, place_b)] =
                [start, end].map(|pose| parts(&local(pose)));
            let turn = turn_a.try_slerp(&turn_b, part, 1e-12).unwrap_or(turn_a);
            let linear = turn.to_rotation_matrix().into_inner() * (a + (b - a) * part);
            let mut own = linear.to_homogeneous();
            own.fixed_view_mut::<3, 1>(0, 3).copy_from(&place_a.lerp(&place_b, part));
            let has_inverse = |parent: &usize| start[*parent].try_inverse().is_some();
            let parent = self.parents[joint].filter(has_inverse);
            worlds[joint] = parent.map_or(own, |parent| worlds[parent] * own);
        }
        worlds
    }
}

/// Splits a frame into stretch, rotation and position.
fn parts(local: &Matrix4<f64>) -> (Matrix3<f64>, UnitQuaternion<f64>, Vector3<f64>) {
    let linear = local.fixed_view::<3, 3>(0, 0).into_owned();
    let (turn, stretch) = polar(&linear).unwrap_or((Matrix3::identity(), linear));
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
    (stretch, turn, local.fixed_view::<3, 1>(0, 3).into_owned())
}

/// Returns the diagonal of the box around the joints in some poses.
fn extent<'a>(poses: impl Iterator<Item = &'a Pose>) -> f64 {
    let origins = poses.flatten().map(|frame| frame.fixed_view::<3, 1>(0, 3).into_owned());
    let bounds = origins.map(|x| (x, x)).reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)));
    bounds.map_or(0.0, |(low, high)| (high - low).norm())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a joint at the origin, turned about z by `angle`, and a joint at the end of its arm of length 1.
    fn arm(angle: f64) -> Pose {
        let turn = Matrix4::from_axis_angle(&Vector3::z_axis(), angle);
        vec![turn, turn * Matrix4::new_translation(&Vector3::new(1.0, 0.0, 0.0))]
    }

    fn sampled(keys: &[f64], fps: Option<f64>, angle: impl Fn(f64) -> f64 + Sync) -> Vec<Sample> {
        let sampling =
            Sampling { fps, clips: &[], shapes: false, still: false, played: true, curves: false };
        let pose = |time: f64| Ok(arm(angle(time)));
        let joints = MovingJoints { parents: &[None, Some(0)], frame: 0.0, pose };
        samples("turn", keys.to_vec(), &sampling, &joints).unwrap()
    }

    fn times(samples: &[Sample]) -> Vec<f64> {
        samples.iter().map(|sample| sample.time).collect()
    }

    #[test]
    fn an_even_turn_needs_only_its_keys() {
        assert_eq!(times(&sampled(&[0.0, 1.0, 2.5], None, |time| time)), [0.0, 1.0, 2.5]);
    }

    #[test]
    fn a_jump_has_two_samples_that_are_neighbours_in_single_precision() {
        let step = |time: f64| if time < 1.0 { 0.0 } else { 1.0 };
        let found = sampled(&[0.0, 1.0, 2.0], None, step);
        let before = f64::from(1.0_f32.next_down());
        assert_eq!(times(&found), [0.0, before, 1.0, 2.0]);
        assert_eq!([step(found[1].at), step(found[2].at)], [0.0, 1.0]);
        // A jump between the frames of a given rate stays a jump.
        assert_eq!(
            times(&sampled(&[0.0, 0.7, 2.0], Some(1.0), |t| f64::from(u8::from(t >= 0.7)))),
            [0.0, f64::from(0.7_f32.next_down()), 0.7, 1.0, 2.0]
        );
    }

    #[test]
    fn baked_frames_are_not_subdivided() {
        let sampling = Sampling {
            fps: None,
            clips: &[],
            shapes: false,
            still: false,
            played: true,
            curves: false,
        };
        // A turn over one baked frame at 24 frames a second, then a curve over ten frames.
        let keys = [0.0, 1.0 / 24.0, 11.0 / 24.0];
        let pose =
            |time: f64| Ok(arm(if time < keys[1] { 100.0 * time * time } else { time * time }));
        let joints = MovingJoints { parents: &[None, Some(0)], frame: 1.0 / 24.0, pose };
        let found = samples("turn", keys.to_vec(), &sampling, &joints).unwrap();
        let times = times(&found);
        assert_eq!(times.iter().filter(|&&time| time < keys[1]).count(), 2, "{times:?}");
        assert!((8..20).contains(&times.len()), "{times:?}");
        let steps = times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 1e-3);
        assert!(steps.fold(f64::MAX, f64::min) > 0.5 / 24.0, "{times:?}");
    }

    #[test]
    fn a_curve_has_enough_samples() {
        let curve = |time: f64| time * time;
        let found = sampled(&[0.0, 1.0], None, curve);
        let measure =
            Measure { parents: &[None, Some(0)], order: vec![0, 1], size: 1.0, least: 0.0 };
        assert!((5..100).contains(&found.len()), "{}", found.len());
        for pair in found.windows(2) {
            for part in [0.1, 0.3, 0.6, 0.9] {
                let [from, to] = [pair[0].time, pair[1].time];
                let blended = measure.blended(&arm(curve(from)), &arm(curve(to)), part);
                let distance = measure.distance(&arm(curve(from + part * (to - from))), &blended);
                assert!(distance < 1.2 * NEAR, "{distance}");
            }
        }
    }
}
