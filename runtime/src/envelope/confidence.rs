//! The confidence in a rotational envelope's pose.

use super::view::Envelope;
use crate::error::{Argument, CallError};
use crate::linear::dot;
use crate::numeric::{greater, lesser, smoothstep, sqrt};

/// Returns the least confidence over the joints: 1 within a joint's trained range, 0 from half the
/// range and 0.1 rad beyond it, a quintic step between.
///
/// - `rotations`: J rotation vectors, of [`crate::stages::gradients`].
///
/// # Errors
/// - [`crate::CallErrorKind::Length`]: `rotations` has another length.
pub fn evaluate(envelope: &Envelope<'_>, rotations: &[[f32; 3]]) -> Result<f32, CallError> {
    Argument::Rotations.check_len(envelope.joint_len(), rotations.len())?;
    let of_joint = |(joint, theta): (usize, &[f32; 3])| {
        let range = envelope.pose_range(joint).unwrap_or_default();
        let excess = greater(sqrt(dot(*theta, *theta)) - range, 0.0) / (0.5 * range + 0.1);
        1.0 - smoothstep(lesser(excess, 1.0))
    };
    Ok(rotations.iter().enumerate().map(of_joint).fold(1.0, lesser))
}
