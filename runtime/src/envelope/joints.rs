//! Stage 1 of the kernel predictor: the joints themselves, and the base of each helper (METHOD §1.9).

use super::view::Envelope;
use crate::error::{Argument, CallError};
use crate::linear::{Matrix3x4, split};

/// Copies the joints' transforms into the palette, bit for bit, and gives each helper that of its
/// dominant joint.
///
/// - `pose`: J skinning matrices, rest to posed, in model space.
/// - `out_palette`: J + P transforms.
///
/// # Errors
/// - [`crate::CallErrorKind::NoStage`]: the model is not of the kernel predictor.
/// - [`crate::CallErrorKind::Length`]: an argument has another length.
/// - [`crate::CallErrorKind::NonFinite`]: a joint's matrix is not finite.
pub fn evaluate(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    out_palette: &mut [Matrix3x4],
) -> Result<(), CallError> {
    envelope.check_stage(!envelope.predictor().reconstructs())?;
    envelope.check_pose(pose)?;
    Argument::Palette.check_len(envelope.palette_len(), out_palette.len())?;
    let (joints, helpers) = split(out_palette, pose.len());
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
