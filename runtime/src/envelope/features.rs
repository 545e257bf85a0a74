//! The pose features: how each joint has turned and moved against its parent (METHOD §1.9).

use super::view::Envelope;
use crate::error::{Argument, CallError};
use crate::linear::{IDENTITY, Matrix3x4, columns, dot};

/// Computes the features phi of a pose: 12 of a joint, exactly 0 in the rest pose.
///
/// A joint j with parent p moves by `M = B_p^-1 B_j = [R | t]`, `B_p` taken as rigid. Its features
/// are the rows of `[R - I | M o - o]`, o its rest origin: the displacement of the origin in the
/// parent's frame. Feature `12 j + 4 r + c` is entry r, c; the root's are 0.
///
/// - `pose`: J skinning matrices, rest to posed, in model space; [`crate::model_space_pose`] makes
///   them from local rotations.
/// - `out_features`: J matrices.
///
/// # Errors
/// - [`crate::CallErrorKind::NoStage`]: the envelope is rotational and has no features.
/// - [`crate::CallErrorKind::Length`]: an argument has another length.
/// - [`crate::CallErrorKind::NonFinite`]: a joint's matrix is not finite.
pub fn evaluate(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    out_features: &mut [Matrix3x4],
) -> Result<(), CallError> {
    envelope.check_stage(envelope.predictor().corrects())?;
    envelope.check_pose(pose)?;
    Argument::Features.check_len(envelope.joint_len(), out_features.len())?;
    for (joint, (map, out)) in pose.iter().zip(out_features).enumerate() {
        let parent = envelope.parent(joint).and_then(|parent| pose.get(parent));
        let origin = envelope.origin(joint).unwrap_or_default();
        *out = parent.map_or([[0.0; 4]; 3], |parent| relative(parent, map, origin));
    }
    Ok(())
}

/// Returns `[R - I | (R - I) o + t]`; the difference is taken first, so that rest is exactly 0.
fn relative(parent: &Matrix3x4, map: &Matrix3x4, origin: [f32; 3]) -> Matrix3x4 {
    let mut apart = *map;
    for (row, parent) in apart.iter_mut().zip(parent) {
        row[3] -= parent[3];
    }
    let [a, b, c] = apart;
    let mut out = [[0.0; 4]; 3];
    for ((row, [x, y, z]), unit) in out.iter_mut().zip(columns(parent)).zip(IDENTITY) {
        for (value, ((a, b), c)) in row.iter_mut().zip(a.iter().zip(&b).zip(&c)) {
            *value = x * a + y * b + z * c;
        }
        row.iter_mut().zip(unit).for_each(|(value, unit)| *value -= unit);
        let [x, y, z, t] = *row;
        row[3] = dot([x, y, z], origin) + t;
    }
    out
}
