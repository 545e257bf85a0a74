//! Stage 1 of the kernel predictor: the joints themselves, and the base of each helper (METHOD §1.9).

use super::Envelope;
use crate::Matrix3x4;
use crate::error::{Argument, EvalError};
use crate::pose;

/// Copies the joints' maps into the palette, bit for bit, and gives each helper that of its
/// dominant joint.
///
/// - `pose`: J skinning matrices, rest to posed, in model space.
/// - `out_palette`: J + P maps.
///
/// # Errors
/// - [`EvalError::Predictor`]: the model is not of the kernel predictor.
/// - [`EvalError::Length`]: an argument has another length.
/// - [`EvalError::NonFinite`]: a joint's matrix is not finite.
pub fn evaluate(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    out_palette: &mut [Matrix3x4],
) -> Result<(), EvalError> {
    envelope.check_stage(!envelope.predictor().reconstructs())?;
    pose::check(envelope, pose)?;
    Argument::Palette.check_len(envelope.palette_len(), out_palette.len())?;
    let (joints, helpers) = super::split(out_palette, pose.len());
    for (out, map) in joints.iter_mut().zip(pose) {
        *out = *map;
    }
    for group in envelope.groups() {
        if let (Some(out), Some(map)) = (helpers.get_mut(group.proxies), pose.get(group.joint)) {
            out.fill(*map);
        }
    }
    Ok(())
}
