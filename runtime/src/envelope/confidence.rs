//! How far a pose turns the joints beyond what training saw (METHOD §1.8).

use super::view::Envelope;
use crate::linear::{Matrix3x4, dot};
use crate::numeric::{greater, lesser, smoothstep, sqrt};

/// Evaluates the stage: [`crate::stages::confidence`] of arguments that have been checked.
pub(crate) fn evaluate(envelope: &Envelope<'_>, rotations: &[[f32; 3]]) -> f32 {
    let angles = rotations.iter().map(|theta| sqrt(dot(*theta, *theta)));
    angles.zip(ranges(envelope)).map(|(angle, range)| within(angle, range, range)).fold(1.0, lesser)
}

/// Evaluates it of each joint where kernel maps tell of the poses nearby, and what they do not hear is all that is left to
/// doubt: from one and a half times its range.
///
/// - `features`: of the joints, whose trace is -2 (1 - cos(angle / 2)): 4 sin(angle / 4) stands for the angle.
pub(crate) fn of_features(
    envelope: &Envelope<'_>,
    features: &[Matrix3x4],
) -> impl Iterator<Item = f32> {
    features.iter().zip(ranges(envelope)).map(|([x, y, z], range)| {
        let angle = 2.0 * sqrt(greater(0.0, -(x[0] + y[1] + z[2])));
        within(angle, 1.5 * range, range)
    })
}

fn ranges(envelope: &Envelope<'_>) -> impl Iterator<Item = f32> {
    envelope.pose_ranges().iter().map(|[range]| f32::from_le_bytes(*range))
}

/// Returns 1 up to an angle, and 0 where it is exceeded by half the range and 0.1.
fn within(angle: f32, most: f32, range: f32) -> f32 {
    let excess = greater(angle - most, 0.0) / (0.5 * range + 0.1);
    1.0 - smoothstep(lesser(excess, 1.0))
}
