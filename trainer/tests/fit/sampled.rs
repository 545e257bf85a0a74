//! Poses to train on: their ranges, their combinations, and the model that they train.

use nalgebra::{Matrix3, Matrix3x4, Rotation3, UnitQuaternion, Vector3};
use sinew_trainer::ErrorKind;
use sinew_trainer::envelope::{Options, train};
use sinew_trainer::evaluate::{Frames, evaluate};
use sinew_trainer::examples::{Examples, PoseRequest, SampledPoses, Skeleton, Split, sample_poses};
use sinew_trainer::progress::Silent;
use std::collections::BTreeSet;

/// Joints of a limb, root first: each at its height, turned by an angle about y at rest.
const JOINTS: [(&str, f64, f64); 4] =
    [("root", 0.0, 0.0), ("upper", 1.0, 0.4), ("lower", 2.0, -0.7), ("tip", 3.0, 0.0)];
/// Rotation vectors of the joints' clips in their rest axes, least and greatest. The tip turns about no axis.
const TURNS: [[[f64; 3]; 2]; 4] = [
    [[0.0; 3]; 2],
    [[-0.7, 0.0, -0.2], [1.0, 0.0, 0.3]],
    [[0.0; 3], [1.6, 0.0, 0.0]],
    [[0.0; 3]; 2],
];
/// Stretch of the tip along y, least and greatest; it narrows to keep its volume.
const STRETCH: [f64; 2] = [0.85, 1.3];
/// Range of the only curve.
const CURVE: [f64; 2] = [-0.5, 1.0];
/// A pose of the limb.
#[derive(Clone, Copy, Debug)]
struct Pose {
    turns: [Vector3<f64>; 4],
    /// Stretch of the tip along x, y and z.
    stretch: Vector3<f64>,
    curve: f64,
}

const REST: Pose = Pose {
    turns: [Vector3::new(0.0, 0.0, 0.0); 4],
    stretch: Vector3::new(1.0, 1.0, 1.0),
    curve: 0.0,
};

fn axes(joint: usize) -> Matrix3<f64> {
    Rotation3::from_axis_angle(&Vector3::y_axis(), JOINTS[joint].2).into_inner()
}

fn origin(joint: usize) -> Vector3<f64> {
    Vector3::y() * JOINTS[joint].1
}

fn rows(linear: &Matrix3<f64>, shift: &Vector3<f64>) -> [[f64; 4]; 3] {
    let map = Matrix3x4::from_columns(&[
        linear.column(0).into_owned(),
        linear.column(1).into_owned(),
        linear.column(2).into_owned(),
        *shift,
    ]);
    [0, 1, 2].map(|row| [0, 1, 2, 3].map(|column| map[(row, column)]))
}

/// Rotation of a joint in model axes by a share of its rotation vector.
fn turned(pose: &Pose, joint: usize, share: f64) -> Matrix3<f64> {
    let turn = Rotation3::from_scaled_axis(pose.turns[joint] * share).into_inner();
    axes(joint) * turn * axes(joint).transpose()
}

impl Pose {
    fn maps(&self) -> Vec<[[f64; 4]; 3]> {
        let (mut linear, mut shift) = (Matrix3::identity(), Vector3::zeros());
        let mut maps = Vec::new();
        for joint in 0..4 {
            let turn = turned(self, joint, 1.0);
            shift += linear * (origin(joint) - turn * origin(joint));
            linear *= turn;
            let stretch = match joint {
                3 => Matrix3::from_diagonal(&self.stretch),
                _ => Matrix3::identity(),
            };
            let own = linear * stretch;
            maps.push(rows(&own, &(shift + (linear - own) * origin(joint))));
        }
        maps
    }

    /// Reads the pose of frame `index`. Turns are about the rest axes of each joint.
    fn read(poses: &SampledPoses, index: usize) -> Self {
        let maps = &poses.transforms[4 * index..][..4];
        let linear = |joint: usize| Matrix3::from_fn(|row, column| maps[joint][row][column]);
        let last = linear(3).transpose() * linear(3);
        let root = last.symmetric_eigen();
        let stretch = root.eigenvectors
            * Matrix3::from_diagonal(&root.eigenvalues.map(f64::sqrt))
            * root.eigenvectors.transpose();
        let mut pose = Pose { stretch: stretch.diagonal(), curve: poses.curves[index], ..REST };
        let mut before = Matrix3::identity();
        for joint in 0..4 {
            let own = match joint {
                3 => linear(3) * stretch.try_inverse().unwrap(),
                _ => linear(joint),
            };
            let turn = axes(joint).transpose() * before.transpose() * own * axes(joint);
            let turn = Rotation3::from_matrix_unchecked(turn);
            pose.turns[joint] = UnitQuaternion::from_rotation_matrix(&turn).scaled_axis();
            before = own;
        }
        pose
    }

    /// Returns whether each joint, and the curve last, has left its rest pose.
    fn moved(&self) -> [bool; 5] {
        let turns = self.turns.map(|turn| turn.norm() > 1e-6);
        [
            turns[0],
            turns[1],
            turns[2],
            (self.stretch - REST.stretch).norm() > 1e-6,
            self.curve.abs() > 1e-6,
        ]
    }
}

fn ramp(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

fn bell(x: f64) -> f64 {
    (-x * x / 0.1).exp()
}

/// Skin of a pose in closed form: each point turns by its share of the rotation of each joint, so that a bent elbow
/// keeps its section, and swells with the elbow's angle, with the curve, and with both together.
fn skin(pose: &Pose, rest: &Vector3<f64>) -> Vector3<f64> {
    let elbow = pose.turns[2].x;
    let swell = 0.15 * elbow * bell(rest.y - 1.6)
        + pose.curve * (0.2 * bell(rest.y - 0.7) + 0.15 * elbow * bell(rest.y - 2.3));
    let mut at = *rest;
    at.x *= 1.0 + swell;
    at.z *= 1.0 + swell;
    let share = ramp(rest.y - 2.5);
    at -= origin(3);
    at += share * (pose.stretch - REST.stretch).component_mul(&at);
    at += origin(3);
    for joint in [3, 2, 1] {
        let share = ramp(rest.y - JOINTS[joint].1 + 0.5);
        at = origin(joint) + turned(pose, joint, share) * (at - origin(joint));
    }
    at
}

const ROUND: usize = 10;
const RINGS: usize = 33;

/// Examples of the limb in some poses, in clips of 50 frames.
fn limb(poses: &[Pose]) -> Examples {
    let point = |number: usize| {
        let angle = std::f64::consts::TAU * (number % ROUND) as f64 / ROUND as f64;
        Vector3::new(0.3 * angle.cos(), (number / ROUND) as f64 * 0.125, 0.3 * angle.sin())
    };
    let rest: Vec<Vector3<f64>> = (0..ROUND * RINGS).map(point).collect();
    let quad = |number: usize| {
        let next = number / ROUND * ROUND + (number + 1) % ROUND;
        [[number, number + ROUND, next + ROUND], [number, next + ROUND, next]]
    };
    let frame = |joint: usize| rows(&axes(joint), &origin(joint));
    let meshes = poses.iter().flat_map(|pose| rest.iter().map(|at| skin(pose, at).into()));
    Examples {
        triangles: (0..ROUND * (RINGS - 1)).flat_map(quad).collect(),
        skeleton: Skeleton {
            names: JOINTS.map(|(name, ..)| name.to_owned()).to_vec(),
            parents: vec![None, Some(0), Some(1), Some(2)],
            rest: (0..4).map(frame).collect(),
            ..Skeleton::default()
        },
        vertices: meshes.collect(),
        transforms: poses.iter().flat_map(Pose::maps).collect(),
        curve_names: vec!["flex".to_owned()],
        curves: poses.iter().map(|pose| pose.curve).collect(),
        split: vec![Split::Train; poses.len()],
        clip_starts: (0..poses.len()).step_by(50).collect(),
        rest: rest.into_iter().map(Into::into).collect(),
        ..Examples::default()
    }
}

/// Stretch that keeps the volume.
fn stretched(along: f64) -> Vector3<f64> {
    let across = along.sqrt().recip();
    Vector3::new(across, along, across)
}

/// Smooth clips over the whole ranges: each number goes back and forth at its own pace, set by `clip`.
fn clips(clip: f64, len: usize) -> Vec<Pose> {
    let pose = |frame: usize| {
        let mut number = 0.0;
        let mut between = |[least, most]: [f64; 2]| {
            number += 1.0;
            let pace = 0.04 + 0.025 * (number * 1.7 + clip * 2.3).sin().abs();
            let phase = pace * frame as f64 + number * number + clip;
            least + (most - least) * (0.5 - 0.5 * (std::f64::consts::TAU * phase).cos())
        };
        let turns = TURNS.map(|[least, most]| {
            Vector3::from([0, 1, 2].map(|axis| between([least[axis], most[axis]])))
        });
        Pose { turns, stretch: stretched(between(STRETCH)), curve: between(CURVE) }
    };
    (0..len).map(pose).collect()
}

fn rig() -> Examples {
    // The ends of each range, so that the ranges are known exactly.
    let [least, most] = [0, 1].map(|end| Pose {
        turns: TURNS.map(|ends| ends[end].into()),
        stretch: stretched(STRETCH[end]),
        curve: CURVE[end],
    });
    limb(&[clips(0.0, 148), vec![least, most]].concat())
}

fn sampled(rig: &Examples, seed: u64) -> SampledPoses {
    sample_poses(rig, &PoseRequest { seed, ..PoseRequest::default() }).unwrap()
}

/// Ranges with a tenth more on either side, but at rest: rotation x and z of `upper`, x of `lower`, stretch and curve.
const RANGES: [[f64; 2]; 5] =
    [[-0.87, 1.17], [-0.25, 0.35], [0.0, 1.76], [0.805, 1.345], [-0.65, 1.15]];

fn numbers(pose: &Pose) -> [f64; 5] {
    [pose.turns[1].x, pose.turns[1].z, pose.turns[2].x, pose.stretch.y, pose.curve]
}

#[test]
fn poses_stay_in_the_ranges_and_reach_every_end_alone() {
    let poses = sampled(&rig(), 0);
    let all: Vec<Pose> = (0..150).map(|index| Pose::read(&poses, index)).collect();
    assert_eq!((all.len(), poses.curves.len(), poses.joints), (150, 150, 3));
    for pose in &all {
        for (number, [least, most]) in numbers(pose).into_iter().zip(RANGES) {
            assert!(number > least - 1e-6 && number < most + 1e-6, "{pose:?}");
        }
        assert!(pose.turns[0].norm() < 1e-6 && pose.turns[3].norm() < 1e-6, "{pose:?}");
        let [_, upper, lower, _] = pose.turns;
        assert!(upper.y.abs() + lower.y.abs() + lower.z.abs() < 1e-6, "{pose:?}");
    }
    for pose in &all[..poses.alone] {
        assert_eq!(pose.moved().iter().filter(|moved| **moved).count(), 1, "{pose:?}");
    }
    for (place, [least, most]) in RANGES.into_iter().enumerate() {
        let own = || all[..poses.alone].iter().map(|pose| numbers(pose)[place]);
        let [low, high] = [own().fold(9.0, f64::min), own().fold(-9.0, f64::max)];
        // Other poses show an end at rest.
        let is_low = least == 0.0 || (low - least).abs() < 1e-6;
        assert!(is_low && (high - most).abs() < 1e-6, "{place}: {low} to {high}");
    }
}

#[test]
fn neighbours_meet_alone_and_in_every_part_of_their_ranges() {
    for seed in 0..5 {
        let poses = sampled(&rig(), seed);
        let all: Vec<Pose> = (0..150).map(|index| Pose::read(&poses, index)).collect();
        let paired = &all[poses.alone..][..poses.paired];
        // The curve has no neighbour: it is the only one.
        for (a, b) in [(1, 2), (2, 3)] {
            let only = |pose: &&Pose| {
                let moved = pose.moved();
                moved[a] && moved[b] && moved.iter().filter(|moved| **moved).count() == 2
            };
            assert_eq!(paired.iter().filter(only).count(), poses.paired / 2, "{a} and {b}");
        }
        // Numbers of neighbours meet in all thirds of their ranges, other numbers in both halves.
        for (parts, a, b) in [(3, 0, 2), (3, 1, 2), (3, 2, 3), (2, 0, 3), (2, 0, 4), (2, 2, 4)] {
            let part = |pose: &Pose, place: usize| {
                let [least, most] = RANGES[place];
                let share = (numbers(pose)[place] - least) / (most - least);
                (share * parts as f64 * 0.999_999) as usize
            };
            let cells: BTreeSet<_> =
                all[poses.alone..].iter().map(|pose| (part(pose, a), part(pose, b))).collect();
            assert_eq!(cells.len(), parts * parts, "seed {seed}, {a} and {b}: {cells:?}");
        }
    }
}

#[test]
fn the_root_stretches_but_turns_and_slides_in_no_pose() {
    let mut moved = rig();
    for (frame, maps) in moved.transforms.chunks_exact_mut(4).enumerate() {
        // The whole character walks, and the root widens by up to a fifth. The other joints stand where the root's
        // stretch moves nothing.
        let far = frame as f64;
        let turn = Rotation3::from_euler_angles(0.3 * far.sin(), 0.1 * far, 0.0).into_inner();
        let widened = Matrix3::from_diagonal(&Vector3::new(1.0 + 0.2 * (far / 149.0), 1.0, 1.0));
        let walked = |linear: Matrix3<f64>, shift: Vector3<f64>| {
            rows(&(turn * linear), &(turn * shift + Vector3::new(0.0, 0.0, 0.1 * far)))
        };
        maps[0] = walked(widened, Vector3::zeros());
        for map in &mut maps[1..] {
            let linear = Matrix3::from_fn(|row, column| map[row][column]);
            *map = walked(linear, map.map(|row| row[3]).into());
        }
    }
    let poses = sampled(&moved, 0);
    assert_eq!(poses.joints, 4);
    let mut widest: f64 = 0.0;
    for maps in poses.transforms.chunks_exact(4) {
        let [[wide, ..], ..] = maps[0];
        let expected =
            rows(&Matrix3::from_diagonal(&Vector3::new(wide, 1.0, 1.0)), &Vector3::zeros());
        let both = maps[0].as_flattened().iter().zip(expected.as_flattened());
        assert!(both.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-9, "{:?}", maps[0]);
        widest = widest.max(wide);
    }
    assert!((widest - 1.22).abs() < 1e-9, "{widest}");
}

#[test]
fn a_joint_slides_along_its_rest_axes_as_far_as_in_training_frames() {
    let mut slides = limb(&[REST; 3]);
    let shift = |far: f64| axes(2) * Vector3::new(far, 0.0, 0.0);
    for (frame, far) in [(1, 0.5), (2, 2.0)] {
        // The tip follows.
        slides.transforms[4 * frame + 2..][..2].fill(rows(&Matrix3::identity(), &shift(far)));
    }
    slides.split[2] = Split::HeldOut;
    let poses = sampled(&slides, 0);
    assert_eq!(poses.joints, 1);
    let mut farthest: f64 = 0.0;
    for maps in poses.transforms.chunks_exact(4) {
        let far = shift(1.0).dot(&Vector3::from(maps[2].map(|row| row[3])));
        let expected = [0.0, 0.0, far, far].map(|far| rows(&Matrix3::identity(), &shift(far)));
        let both = maps.as_flattened().as_flattened().iter();
        let both = both.zip(expected.as_flattened().as_flattened());
        assert!(both.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-9, "{maps:?}");
        farthest = farthest.max(far);
    }
    assert!((farthest - 0.55).abs() < 1e-9, "{farthest}");
}

#[test]
fn equal_seeds_give_equal_poses() {
    let rig = rig();
    assert_eq!(sampled(&rig, 3), sampled(&rig, 3));
    assert_ne!(sampled(&rig, 3).transforms, sampled(&rig, 4).transforms);
}

#[test]
fn far_joints_share_poses_if_poses_are_few() {
    let poses = sample_poses(&rig(), &PoseRequest { frames: 12, ..PoseRequest::default() });
    let poses = poses.unwrap();
    assert_eq!((poses.transforms.len(), poses.alone, poses.paired), (12 * 4, 4, 4));
    let moved: Vec<[bool; 5]> = (0..4).map(|index| Pose::read(&poses, index).moved()).collect();
    // Two poses for each half of the movers; `upper` and `lower`, which are neighbours, are apart.
    assert!(moved.iter().all(|moved| !(moved[1] && moved[2])), "{moved:?}");
    assert!(
        (1..5).all(|mover| moved.iter().filter(|moved| moved[mover]).count() == 2),
        "{moved:?}"
    );
}

#[test]
fn further_roots_follow_the_joint_that_carries_them() {
    let mut rig = rig();
    let names = rig.skeleton.names.clone();
    // `lower` is a root of its own in the source.
    rig.skeleton.parents[2] = Some(0);
    rig.skeleton.roots = vec![2];
    let (found, expected) = (sampled(&rig, 0), sampled(&self::rig(), 0));
    assert_eq!(names[2], "lower");
    assert_eq!(found, expected);
}

#[test]
fn degrees_replace_clips() {
    let still = limb(&[REST; 6]);
    let error = sample_poses(&still, &PoseRequest::default()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Missing);
    assert_eq!(
        error.to_string(),
        "its training frames move no joint and no curve, so its ranges are unknown: give --degrees N, or clips that \
         show the ranges"
    );
    let request = PoseRequest { degrees: Some(30.0), ..PoseRequest::default() };
    let poses = sample_poses(&still, &request).unwrap();
    assert_eq!(poses.joints, 3);
    assert_eq!(
        sample_poses(&rig(), &request).unwrap(),
        poses,
        "the clips of a rig count for nothing"
    );
    let all: Vec<Pose> = (0..150).map(|index| Pose::read(&poses, index)).collect();
    for joint in 1..4 {
        for axis in 0..3 {
            let turns = || all.iter().map(|pose| pose.turns[joint][axis].to_degrees());
            let [low, high] = [turns().fold(0.0, f64::min), turns().fold(0.0, f64::max)];
            assert!((low + 30.0).abs() < 1e-6 && (high - 30.0).abs() < 1e-6, "{low} to {high}");
        }
    }
    let curve = || all.iter().map(|pose| pose.curve);
    assert_eq!([curve().fold(9.0, f64::min), curve().fold(-9.0, f64::max)], [0.0, 1.0]);
    // The root alone cannot be posed.
    let mut alone = limb(&[REST; 6]);
    alone.skeleton = Skeleton::still();
    alone.transforms.truncate(6);
    alone.curve_names.clear();
    alone.curves.clear();
    let error = sample_poses(&alone, &request).unwrap_err();
    assert_eq!(
        error.to_string(),
        "it has neither a curve nor a joint beside the root: there is nothing to pose"
    );
}

#[test]
fn sampled_poses_train_as_well_as_clips() {
    let random = limb(&clips(0.0, 150));
    let poses = sampled(&random, 0);
    let all: Vec<Pose> = (0..150).map(|index| Pose::read(&poses, index)).collect();
    let sampled = limb(&all);
    // The skin of the closed form belongs to the sampled joints.
    for (own, other) in sampled.transforms.iter().zip(&poses.transforms) {
        let both = own.as_flattened().iter().zip(other.as_flattened());
        assert!(both.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-6, "{own:?} {other:?}");
    }
    let mut new = limb(&clips(5.0, 60));
    new.split = vec![Split::HeldOut; 60];
    let [by_clips, by_poses] = [&random, &sampled].map(|examples| {
        let model = train(examples, &Options::default(), &Silent).unwrap().model;
        let found = evaluate(&model, None, &new, Frames::Of(Split::HeldOut)).unwrap();
        found.errors.rms_percent
    });
    assert!(by_poses < 1.5 * by_clips, "{by_poses} by sampled poses, {by_clips} by clips");
}
