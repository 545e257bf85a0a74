//! How the joints move: smooth random clips inside the range of motion.

use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::rotation::rotation;
use super::shape::{above, arm, origins};
use crate::examples::{Matrix3x4, Split};

/// Longest clip, frames.
const CLIP: usize = 10;
/// Frames from one random pose to the next.
const STRIDE: usize = 3;

/// Degrees of freedom with their ranges: degrees, and metres for the last.
const RANGES: [(f64, f64); 13] = [
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

/// One pose: rotations relative to the parent in the rest pose's axes, radians.
#[derive(Clone, Debug)]
pub(super) struct Pose {
    pub(super) clavicle: Vector3<f64>,
    pub(super) swing: Vector3<f64>,
    pub(super) turn: f64,
    pub(super) elbow: f64,
    pub(super) twist: f64,
    pub(super) hand: Vector3<f64>,
    chest: Vector3<f64>,
    shift: Vector3<f64>,
}

/// Consecutive frames of one use.
pub(super) struct Clip {
    split: Split,
    /// The frame at which each random pose is reached is a multiple of the stride.
    keys: Vec<[f64; 13]>,
    len: usize,
}

/// The axis about which the elbow and the wrist bend: it turns the arm forward.
pub(super) fn hinge() -> Vector3<f64> {
    -above()
}

/// Draws clips for `train` and `held_out` frames, held-out clips spread among the others.
pub(super) fn clips(train: usize, held_out: usize, seed: u64) -> Vec<Clip> {
    let mut clips = Vec::new();
    for (stream, split, frame_len) in [(0, Split::Train, train), (1, Split::HeldOut, held_out)] {
        // A stream of their own: held-out clips do not change with the number of training frames.
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        for begin in (0..frame_len).step_by(CLIP) {
            let len = CLIP.min(frame_len - begin);
            let keys = (0..=(len - 1).div_ceil(STRIDE)).map(|_| key(&mut random)).collect();
            let middle = (begin + len / 2) as f64 / frame_len as f64;
            clips.push((middle, Clip { split, keys, len }));
        }
    }
    clips.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    clips.into_iter().map(|(_, clip)| clip).collect()
}

fn key(random: &mut ChaCha8Rng) -> [f64; 13] {
    // Easing draws the ends of a range more often than its middle, as range-of-motion clips do.
    RANGES.map(|(low, high)| low + (high - low) * ease(random.random()))
}

fn ease(x: f64) -> f64 {
    x * x * (3.0 - 2.0 * x)
}

impl Clip {
    /// Gives the frames in order, eased from one random pose to the next.
    pub(super) fn frames(&self) -> impl Iterator<Item = (Split, Pose)> + '_ {
        (0..self.len).map(|frame| {
            let x = (frame % STRIDE) as f64 / STRIDE as f64;
            let from = &self.keys[frame / STRIDE];
            let to = self.keys.get(frame / STRIDE + 1).unwrap_or(from);
            let freedoms = std::array::from_fn(|freedom| {
                from[freedom] + (to[freedom] - from[freedom]) * ease(x)
            });
            (self.split, Pose::new(&freedoms))
        })
    }
}

impl Pose {
    /// Makes a pose of degrees of freedom in the order and units of the ranges.
    pub(super) fn new(freedoms: &[f64; 13]) -> Self {
        let [raised, forward, up, front, turn, elbow, twist, bent, tilted, yaw, bow, lean, shift] =
            std::array::from_fn(|freedom| {
                freedoms[freedom] * if freedom < 12 { std::f64::consts::PI / 180.0 } else { 1.0 }
            });
        Self {
            clavicle: Vector3::z() * raised - Vector3::y() * forward,
            swing: Vector3::z() * up + hinge() * front,
            turn,
            elbow,
            twist,
            hand: hinge() * bent + Vector3::z() * tilted,
            chest: Vector3::new(bow, yaw, lean),
            shift: Vector3::new(shift, 0.3 * shift, -0.5 * shift),
        }
    }

    /// Gives the map of the chest, which carries everything.
    pub(super) fn root(&self) -> (Matrix3<f64>, Vector3<f64>) {
        let [origin, ..] = origins();
        let linear = rotation(&self.chest);
        (linear, origin + self.shift - linear * origin)
    }

    /// Gives the maps from the rest pose of the joints.
    pub(super) fn maps(&self) -> [Matrix3x4; 7] {
        let own = [
            rotation(&self.clavicle),
            rotation(&self.swing),
            rotation(&(arm() * self.turn)),
            rotation(&(hinge() * self.elbow)),
            rotation(&(arm() * self.twist)),
            rotation(&self.hand),
        ];
        let (mut linear, mut shift) = self.root();
        let mut maps = [rows(&linear, &shift); 7];
        for (joint, (own, origin)) in own.iter().zip(&origins()[1..]).enumerate() {
            shift += linear * (origin - own * origin);
            linear *= own;
            maps[joint + 1] = rows(&linear, &shift);
        }
        maps
    }
}

fn rows(linear: &Matrix3<f64>, shift: &Vector3<f64>) -> Matrix3x4 {
    [0, 1, 2].map(|row| [linear[(row, 0)], linear[(row, 1)], linear[(row, 2)], shift[row]])
}
