//! The motion: smooth random clips within the range of motion, and skin points that follow the joints.

use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::shape::{
    ELBOW, JOINTS, Point, SHOULDER, WRIST, above, arm, bell, origins, ramp, rotation,
};
use crate::examples::{Matrix3x4, Split};
use crate::numeric::affine::{joined, to_rows};

/// Longest clip, in frames.
const CLIP: usize = 10;
/// Frames from one random pose to the next.
const STRIDE: usize = 3;

/// Degrees of freedom with their ranges, in degrees; the last in metres.
const RANGES: [(f64, f64); FREEDOMS] = [
    (-8.0, 20.0),  // clavicle raised
    (-12.0, 16.0), // clavicle forward
    (-55.0, 40.0), // upper arm raised
    (-30.0, 60.0), // upper arm forward
    (-20.0, 20.0), // upper arm turned
    (0.0, 118.0),  // elbow bent
    (-85.0, 85.0), // forearm turned
    (-50.0, 50.0), // wrist bent
    (-15.0, 25.0), // wrist tilted
    (-40.0, 40.0), // chest turned
    (-15.0, 15.0), // chest bowed
    (-10.0, 10.0), // chest tilted
    (-0.1, 0.1),   // chest moved
];
const FREEDOMS: usize = 13;

/// A pose: rotations relative to the parent joint in the rest pose's axes, in radians.
pub(super) struct Pose {
    pub(super) clavicle: Vector3<f64>,
    pub(super) swing: Vector3<f64>,
    pub(super) turn: f64,
    pub(super) elbow: f64,
    pub(super) twist: f64,
    pub(super) hand: Vector3<f64>,
    /// Map of the chest, which carries all joints.
    pub(super) chest: (Matrix3<f64>, Vector3<f64>),
}

/// Consecutive frames with the same use.
pub(super) struct MotionClip {
    split: Split,
    /// Random poses, one every [`STRIDE`] frames.
    keys: Vec<[f64; FREEDOMS]>,
    frame_len: usize,
}

/// Returns the axis about which elbow and wrist bend the arm forward.
pub(super) fn hinge() -> Vector3<f64> {
    -above()
}

/// Draws clips for `train` and `held_out` frames. Held-out clips are spread among the others.
pub(super) fn clips(train: usize, held_out: usize, seed: u64) -> Vec<MotionClip> {
    let mut clips = Vec::new();
    for (stream, split, total) in [(0, Split::Train, train), (1, Split::HeldOut, held_out)] {
        // Separate random streams: held-out clips do not depend on the training clips.
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        for begin in (0..total).step_by(CLIP) {
            let frame_len = CLIP.min(total - begin);
            let key_len = 1 + (frame_len - 1).div_ceil(STRIDE);
            let keys = (0..key_len).map(|_| key(&mut random)).collect();
            let middle = (begin as f64 + 0.5 * frame_len as f64) / total as f64;
            clips.push((middle, MotionClip { split, keys, frame_len }));
        }
    }
    clips.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    clips.into_iter().map(|(_, clip)| clip).collect()
}

/// Draws a pose. The ends of each range are more frequent than the middle, as in range-of-motion clips.
fn key(random: &mut ChaCha8Rng) -> [f64; FREEDOMS] {
    RANGES.map(|(low, high)| low + (high - low) * ramp(random.random(), 0.0, 1.0))
}

impl MotionClip {
    /// Lists the frames in order, eased from one random pose to the next.
    pub(super) fn frames(&self) -> impl Iterator<Item = (Split, Pose)> + '_ {
        (0..self.frame_len).map(|frame| {
            let part = ramp((frame % STRIDE) as f64, 0.0, STRIDE as f64);
            let from = &self.keys[frame / STRIDE];
            let to = self.keys.get(frame / STRIDE + 1).unwrap_or(from);
            let freedoms =
                std::array::from_fn(|freedom| from[freedom] + (to[freedom] - from[freedom]) * part);
            (self.split, Pose::new(&freedoms))
        })
    }
}

impl Pose {
    /// Makes a pose from degrees of freedom, in the order and units of [`RANGES`].
    pub(super) fn new(freedoms: &[f64; FREEDOMS]) -> Self {
        let &[.., moved] = freedoms;
        let [raised, forward, up, front, turn, elbow, twist, bent, tilted, yaw, bow, lean, _] =
            freedoms.map(|degrees| degrees * (std::f64::consts::PI / 180.0));
        let [chest, ..] = origins();
        let linear = rotation(&Vector3::new(bow, yaw, lean));
        let shift = Vector3::new(moved, 0.3 * moved, -0.5 * moved);
        Self {
            clavicle: Vector3::z() * raised - Vector3::y() * forward,
            swing: Vector3::z() * up + hinge() * front,
            turn,
            elbow,
            twist,
            hand: hinge() * bent + Vector3::z() * tilted,
            chest: (linear, chest + shift - linear * chest),
        }
    }

    /// Returns the maps of the joints from the rest pose.
    pub(super) fn maps(&self) -> [Matrix3x4; JOINTS.len()] {
        let turns = [
            self.clavicle,
            self.swing,
            arm() * self.turn,
            hinge() * self.elbow,
            arm() * self.twist,
            self.hand,
        ];
        let (mut linear, mut shift) = self.chest;
        let mut maps = [to_rows(&joined(&linear, &shift)); JOINTS.len()];
        for (joint, (turn, origin)) in turns.iter().zip(&origins()[1..]).enumerate() {
            let turn = rotation(turn);
            shift += linear * (origin - turn * origin);
            linear *= turn;
            maps[joint + 1] = to_rows(&joined(&linear, &shift));
        }
        maps
    }
}

/// A point of the skin and its shares of each joint's rotation.
///
/// With a share s, the skin turns by s times the joint's rotation about the joint's origin. A section inside an elbow
/// turns half way and keeps its size; a blend of two matrices would flatten it.
pub(super) struct Flesh {
    rest: Vector3<f64>,
    /// Shares, 0 on the chest's side of the joint and 1 on the hand's side.
    clavicle: f64,
    swing: f64,
    turn: f64,
    elbow: f64,
    twist: f64,
    hand: f64,
    /// Displacement when the elbow is fully bent.
    bent: Vector3<f64>,
    /// Displacement when the upper arm is fully raised.
    raised: Vector3<f64>,
    /// Displacement when the upper arm is fully forward.
    forward: Vector3<f64>,
}

/// Angles of full swelling in radians: the elbow's and the upper arm's.
const FULL: (f64, f64) = (2.06, 1.4);

impl Flesh {
    /// Computes the shares of a point of the rest skin.
    pub(super) fn new(point: &Point) -> Self {
        let &Point { position, along, around: (up, front) } = point;
        // The sections of the chest are not across the arm, so the distance along the arm's axis counts.
        let outward = (position - SHOULDER).dot(&arm());
        let sides = bell(along, ELBOW, 0.035) * up;
        let deltoid = bell(along, 0.03, 0.06) * square(up.max(0.0));
        let breast = bell(along, -0.05, 0.05) * square(front.max(0.0));
        Self {
            rest: position,
            clavicle: ramp(position.x, -0.025, 0.12),
            swing: ramp(outward, -0.09, 0.09),
            turn: ramp(along, 0.0, 0.125),
            elbow: ramp(along, ELBOW - 0.12, ELBOW + 0.12),
            twist: ramp(along, ELBOW - 0.01, WRIST),
            hand: ramp(along, WRIST - 0.05, WRIST + 0.05),
            bent: Vector3::z() * bent(along, front) + above() * (0.008 * sides),
            raised: above() * (0.014 * deltoid),
            forward: Vector3::z() * (0.016 * breast),
        }
    }

    /// Moves the point to a pose: adds the swelling at rest, then applies the share of each joint, the hand first.
    pub(super) fn posed(&self, pose: &Pose) -> Vector3<f64> {
        let [_, clavicle, shoulder, _, elbow, _, wrist] = origins();
        let swollen = self.rest
            + self.bent * (pose.elbow / FULL.0)
            + self.raised * (pose.swing.z / FULL.1)
            + self.forward * (pose.swing.dot(&hinge()) / FULL.1);
        let turns = [
            (wrist, pose.hand * self.hand),
            (elbow, arm() * (pose.twist * self.twist)),
            (elbow, hinge() * (pose.elbow * self.elbow)),
            (shoulder, arm() * (pose.turn * self.turn)),
            (shoulder, pose.swing * self.swing),
            (clavicle, pose.clavicle * self.clavicle),
        ];
        let in_chest = turns
            .iter()
            .fold(swollen, |at, (origin, turn)| origin + rotation(turn) * (at - origin));
        let (linear, shift) = pose.chest;
        linear * in_chest + shift
    }
}

/// Returns the forward displacement when the elbow bends: biceps and forearm move forward, the triceps and the point of
/// the elbow backward.
fn bent(along: f64, front: f64) -> f64 {
    let biceps = 0.030 * bell(along, 0.135, 0.04);
    let forearm = 0.010 * bell(along, 0.335, 0.035);
    let triceps = 0.006 * bell(along, 0.13, 0.06);
    let point = 0.008 * bell(along, ELBOW, 0.03);
    (biceps + forearm) * square(front.max(0.0)) - (triceps + point) * square(front.min(0.0))
}

fn square(x: f64) -> f64 {
    x * x
}
