//! The confidence in a rotational envelope's pose.

use super::view::Envelope;
use crate::linear::{Le, dot};
use crate::numeric::{greater, lesser, smoothstep, sqrt};

/// Evaluates the stage: [`crate::stages::confidence`] of arguments that have been checked.
pub(crate) fn evaluate(envelope: &Envelope<'_>, rotations: &[[f32; 3]]) -> f32 {
    let of_joint = |(theta, [range]): (&[f32; 3], &[Le; 1])| {
        let range = f32::from_le_bytes(*range);
        let excess = greater(sqrt(dot(*theta, *theta)) - range, 0.0) / (0.5 * range + 0.1);
        1.0 - smoothstep(lesser(excess, 1.0))
    };
    rotations.iter().zip(envelope.pose_ranges()).map(of_joint).fold(1.0, lesser)
}
