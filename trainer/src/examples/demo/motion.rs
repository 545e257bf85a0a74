//! How the joints move: smooth random clips inside the range of motion.

use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::rotation::{ramp, rotation};
use super::shape::{JOINTS, above, arm, origins};
use crate::examples::{Matrix3x4, Split};
use crate::numeric::affine::{joined, to_rows};

/// Longest clip, frames.
const CLIP: usize = 10;
/// Frames from one random pose to the next.
const STRIDE: usize = 3;

/// Degrees of freedom with their ranges: degrees, and metres for the last.
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

/// One pose: rotations against the parent joint in the rest pose's axes, radians.
pub(super) struct Pose {
    pub(super) clavicle: Vector3<f64>,
    pub(super) swing: Vector3<f64>,
    pub(super) turn: f64,
    pub(super) elbow: f64,
    pub(super) twist: f64,
    pub(super) hand: Vector3<f64>,
    /// Map of the chest, which carries everything.
    pub(super) chest: (Matrix3<f64>, Vector3<f64>),
}

/// Consecutive frames of one use.
pub(super) struct MotionClip {
    split: Split,
    /// Random poses, one every stride.
    keys: Vec<[f64; FREEDOMS]>,
    frame_len: usize,
}

/// Points along the axis about which elbow and wrist bend the arm forward.
pub(super) fn hinge() -> Vector3<f64> {
    -above()
}

/// Draws clips for `train` and `held_out` frames, held-out clips spread among the others.
pub(super) fn clips(train: usize, held_out: usize, seed: u64) -> Vec<MotionClip> {
    let mut clips = Vec::new();
    for (stream, split, total) in [(0, Split::Train, train), (1, Split::HeldOut, held_out)] {
        // A stream of its own, so that held-out clips do not depend on the training clips.
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

/// Draws the ends of every range more often than its middle, as range-of-motion clips do.
fn key(random: &mut ChaCha8Rng) -> [f64; FREEDOMS] {
    RANGES.map(|(low, high)| low + (high - low) * ramp(random.random(), 0.0, 1.0))
}

impl MotionClip {
    /// Gives the frames in order, eased from one random pose to the next.
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
    /// Makes a pose of degrees of freedom, in the order and units of the ranges.
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

    /// Gives the maps of the joints from the rest pose.
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
