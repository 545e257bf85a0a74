//! Range of each joint and curve in the training poses, and other frames that leave the range.

use super::context::{Context, Turn, Turns, worst_first};
use super::finding::FrameName;
use super::thresholds::{BENT, DISTINCT, LARGE_BEND, OUTSIDE_CURVE, OUTSIDE_RANGE, SLIDE, STILL};
use crate::envelope::correction::features::Features;
use crate::envelope::lbs::poses::Poses;
use crate::examples::Split;
use crate::numeric::affine::Strain;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use serde::Serialize;

/// Range of a joint in the training poses, relative to its parent. Angles are in degrees from the rest pose.
#[derive(Clone, Debug, Serialize)]
pub struct Coverage {
    /// Name of the joint.
    pub joint: String,
    /// Number of vertices that follow the joint most.
    pub vertices: usize,
    /// RMS error of LBS over these vertices in the training frames, in % of the diagonal.
    pub lbs_percent: f64,
    /// The error in millimetres; `None` if the unit is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lbs_mm: Option<f64>,
    /// Largest angle.
    pub degrees: f64,
    /// Axis of most of the rotation, in the rest pose's model axes.
    pub axis: [f64; 3],
    /// Smallest and largest angle about the axis.
    pub twist: [f64; 2],
    /// Largest angle across the axis.
    pub swing: f64,
    /// Largest displacement of the joint's origin, in % of the diagonal.
    pub slide_percent: f64,
    /// Least and greatest factor of length, along any direction; 1 and 1 if the joint does not stretch.
    pub stretch: [f64; 2],
    /// Number of poses that differ by more than a tenth of the largest angle.
    pub distinct: usize,
    /// Held-out and extreme frames that bend the joint outside the trained range.
    pub beyond: Vec<FrameOutside>,
}

/// A frame that bends a joint outside the trained range.
#[derive(Clone, Debug, Serialize)]
pub struct FrameOutside {
    /// The frame.
    pub frame: FrameName,
    /// Distance of the nearest training frame, in degrees.
    pub degrees: f64,
}

/// Range of a curve in the training poses.
#[derive(Clone, Debug, Serialize)]
pub struct CurveCoverage {
    /// Name of the curve.
    pub curve: String,
    /// Least and greatest value.
    pub range: [f64; 2],
    /// Number of values that differ by more than a tenth of the range.
    pub distinct: usize,
    /// Number of held-out and extreme frames whose value lies outside the range by more than a tenth of it.
    pub beyond: usize,
    /// Share of the skin's motion beyond LBS that a line in this curve alone explains, in % of the squared motion about
    /// its mean. Shares of curves that move together overlap.
    pub explained_percent: f64,
}

/// A joint and its parent that both move a lot, but never together in training.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointPair {
    /// The joint.
    pub joint: String,
    /// Its parent.
    pub parent: String,
}

impl Coverage {
    /// Returns whether the joint moves in training.
    pub fn moves(&self) -> bool {
        self.degrees > STILL || SLIDE * self.slide_percent > 100.0 * STILL
    }
}

/// Measures every joint, in order. The reference root has no parent and does not move.
pub(super) fn coverage(context: &Context<'_>) -> Vec<Coverage> {
    let others: Vec<usize> = (0..context.examples.frame_len())
        .filter(|&frame| context.examples.split[frame] != Split::Train)
        .collect();
    let poses = Poses::new(context.examples, &others);
    let poses = poses.local((context.training.centre, context.training.unit));
    let others = (others, Turns::new(&poses, Features::of(context.training)));
    let skins = context.lbs_residuals().skins();
    let joints = 0..if context.examples.skeleton.is_still { 0 } else { skins.len() };
    joints.into_par_iter().map(|joint| of(context, joint, &skins[joint], &others)).collect()
}

fn of(
    context: &Context<'_>,
    joint: usize,
    skin: &[usize],
    (others, turns): &(Vec<usize>, Turns),
) -> Coverage {
    let training: Vec<&Turn> =
        (0..context.turns.len()).map(|i| context.turns.of(i, joint)).collect();
    let axis = main_axis(&training);
    let about: Vec<(f64, f64)> = training.iter().map(|turn| twist_and_swing(turn, &axis)).collect();
    let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
    let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    let twists = || about.iter().map(|(twist, _)| *twist);
    let mut beyond: Vec<FrameOutside> = others
        .iter()
        .enumerate()
        .map(|(i, &frame)| FrameOutside {
            frame: FrameName::new(context.clips, frame),
            degrees: context.turns.nearest(joint, turns.of(i, joint)),
        })
        .filter(|beyond| beyond.degrees > OUTSIDE_RANGE)
        .collect();
    beyond.sort_by(|a, b| b.degrees.total_cmp(&a.degrees));
    let lbs_percent = 100.0 * context.rms_of(skin);
    let poses = &context.training.poses;
    let gap = DISTINCT * context.turns.largest_bend(joint);
    Coverage {
        joint: context.joint(joint).to_owned(),
        vertices: skin.len(),
        lbs_percent,
        lbs_mm: context.mm(lbs_percent),
        degrees: most(&mut training.iter().map(|turn| turn.rotation.angle().to_degrees())),
        axis: axis.into(),
        twist: [least(&mut twists()), twists().fold(f64::NEG_INFINITY, f64::max)],
        swing: most(&mut about.iter().map(|(_, swing)| *swing)),
        slide_percent: 100.0 * most(&mut training.iter().map(|turn| turn.slide.norm())),
        stretch: stretch((0..poses.len()).map(|pose| poses.strain(pose, joint))),
        distinct: distinct(&training, |a, b| a.gap(b) > gap),
        beyond,
    }
}

/// Measures every curve, in order.
pub(super) fn curves(context: &Context<'_>) -> Vec<CurveCoverage> {
    let (examples, poses) = (context.examples, &context.training.poses);
    let others = || (0..examples.frame_len()).filter(|&f| examples.split[f] != Split::Train);
    let of = |(at, name): (usize, &String)| {
        let [least, most] = poses.curve_ranges()[at];
        let values: Vec<f64> = (0..poses.len()).map(|pose| poses.curves(pose)[at]).collect();
        let beyond = |&frame: &usize| {
            let value = examples.curves_of(frame)[at];
            (least - value).max(value - most) > OUTSIDE_CURVE * (most - least)
        };
        CurveCoverage {
            curve: name.clone(),
            range: [least, most],
            distinct: distinct(&values, |a, b| (a - b).abs() > DISTINCT * (most - least)),
            beyond: others().filter(beyond).count(),
            explained_percent: 100.0 * explained(context, &values),
        }
    };
    examples.curve_names.iter().enumerate().collect::<Vec<_>>().into_par_iter().map(of).collect()
}

/// Returns the share of the squared LBS residuals about their means that a line in some values explains.
fn explained(context: &Context<'_>, values: &[f64]) -> f64 {
    let len = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / len;
    let size: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    let (mut along, mut all) = (0.0, 0.0);
    for vertex in 0..context.dominant.len() {
        let column = context.residuals.col_as_slice(vertex);
        for axis in 0..3 {
            let entries = || column.iter().skip(axis).step_by(3);
            let centre = entries().sum::<f64>() / len;
            let product: f64 = entries().zip(values).map(|(r, value)| r * (value - mean)).sum();
            along += product * product;
            all += entries().map(|r| (r - centre).powi(2)).sum::<f64>();
        }
    }
    if size > 0.0 && all > 0.0 { along / (size * all) } else { 0.0 }
}

/// Returns the least and the greatest factor of length of strains: the strain of a direction with the factor s is
/// (s² - 1) / 2.
fn stretch(strains: impl Iterator<Item = Strain>) -> [f64; 2] {
    strains.fold([1.0, 1.0], |[least, most], [xx, xy, xz, yy, yz, zz]| {
        let strains = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).symmetric_eigenvalues();
        let factor = |strain: f64| (1.0 + 2.0 * strain).max(0.0).sqrt();
        [least.min(factor(strains.min())), most.max(factor(strains.max()))]
    })
}

/// Returns the axis of most of the rotation, with a positive sum of angles.
fn main_axis(turns: &[&Turn]) -> Vector3<f64> {
    let angles: Vec<Vector3<f64>> = turns.iter().map(|turn| turn.rotation.scaled_axis()).collect();
    let spread: Matrix3<f64> = angles.iter().map(|angle| angle * angle.transpose()).sum();
    let eigen = spread.symmetric_eigen();
    let axis: Vector3<f64> = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into();
    let sum: f64 = angles.iter().map(|angle| angle.dot(&axis)).sum();
    if sum < 0.0 { -axis } else { axis }
}

/// Returns the angles about an axis and across the axis, in degrees.
fn twist_and_swing(turn: &Turn, axis: &Vector3<f64>) -> (f64, f64) {
    let q = turn.rotation.quaternion();
    let (w, along) =
        if q.w < 0.0 { (-q.w, -q.imag().dot(axis)) } else { (q.w, q.imag().dot(axis)) };
    let beside = (q.imag() - axis * q.imag().dot(axis)).norm();
    let swing = 2.0 * beside.atan2(w.hypot(along));
    (2.0 * along.atan2(w).to_degrees(), swing.to_degrees())
}

/// Counts items that differ from each other, in the order of the frames.
fn distinct<T: Copy>(items: &[T], differ: impl Fn(T, T) -> bool) -> usize {
    let mut kept: Vec<T> = Vec::new();
    for &item in items {
        if kept.iter().all(|&other| differ(other, item)) {
            kept.push(item);
        }
    }
    kept.len()
}

/// Lists joints that never bend together with their parents, the largest error of LBS first.
pub(super) fn never_together(context: &Context<'_>) -> Vec<JointPair> {
    let parents = &context.examples.skeleton.parents;
    let skins = context.lbs_residuals().skins();
    let error = |joint: usize| context.rms_of(&skins[joint]);
    let pairs = (0..parents.len()).filter(|&joint| {
        let Some(parent) = parents[joint] else { return false };
        let both = [joint, parent].map(|j| (j, context.turns.usual_bend(j)));
        let bent = |i: usize| both.iter().all(|&(j, most)| context.turns.bend(i, j) > BENT * most);
        both.iter().all(|&(_, most)| most > LARGE_BEND) && !(0..context.turns.len()).any(bent)
    });
    worst_first(pairs, error)
        .into_iter()
        .filter_map(|joint| {
            let parent = context.joint(parents[joint]?).to_owned();
            Some(JointPair { joint: context.joint(joint).to_owned(), parent })
        })
        .collect()
}
