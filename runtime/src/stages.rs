//! The stages of an envelope, for tests of other backends and for measurements.
//!
//! [`crate::Envelope::palette`] composes the stages; [`crate::SkinJob`] is the last stage.

use crate::envelope::pose::Pose;
use crate::envelope::{self, Envelope, STRAIN_LEN};
use crate::error::{Argument, CallError};
use crate::linear::{Columns, Matrix3x4};

/// Stage polar: splits the linear part L of each joint into the nearest rotation and the strain
/// `(LᵀL - I) / 2`. The first stage of an envelope whose joints stretch.
///
/// A joint whose determinant is below 1e-3 is hidden or mirrored: both results are 0. A joint whose
/// [`Envelope::stretch_range`] is 0 has L as its rotation.
///
/// - `pose`: J skinning matrices, rest to posed, in model space.
/// - `out_turns`: J rotations, as three columns.
/// - `out_strains`: J strains: xx, xy, xz, yy, yz, zz. For a kernel envelope, the features from
///   `12 J` on.
///
/// # Errors
/// - [`crate::CallErrorKind::NoStage`]: no joint stretches.
/// - [`crate::CallErrorKind::Length`]: an argument has another length.
/// - [`crate::CallErrorKind::NonFinite`]: a joint's matrix is not finite.
pub fn polar(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    out_turns: &mut [Columns],
    out_strains: &mut [[f32; STRAIN_LEN]],
) -> Result<(), CallError> {
    envelope.check_stage(envelope.stretches())?;
    envelope.check_joints(pose)?;
    Argument::Turns.check_len(envelope.joint_len(), out_turns.len())?;
    Argument::Strains.check_len(envelope.joint_len(), out_strains.len())?;
    envelope::polar::polar(envelope, pose, out_turns, out_strains);
    Ok(())
}

/// Stage gradients: computes the joints' transforms relative to the root, their rotations, and the
/// predicted gradients.
///
/// - `pose`: J skinning matrices, rest to posed, in model space.
/// - `turns`, `strains`: from [`polar`]; empty if no joint stretches.
/// - `out_relative`: 4 J columns, the stack q of METHOD §1.7.3. `[4 j + c]` is column c of `B_r^-1
///   B_j`, with `B_r` taken as rigid if no joint stretches. The root's transform is exactly `[I |
///   0]`.
/// - `out_rotations`: J rotation vectors theta_j in radians, each relative to its parent; 0 for the
///   root. A matrix that is not a rotation gives the vector of its nearest quaternion.
/// - `out_gradients`: 3 P columns, the stack d. `[3 l + c]` is column c of `D_l`, without the
///   root's motion.
///
/// # Errors
/// - [`crate::CallErrorKind::NoStage`]: the model uses the kernel predictor and has no keys.
/// - [`crate::CallErrorKind::Length`]: an argument has another length.
/// - [`crate::CallErrorKind::NonFinite`]: a joint's matrix is not finite.
pub fn gradients(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    (turns, strains): (&[Columns], &[[f32; STRAIN_LEN]]),
    out_relative: &mut [[f32; 3]],
    out_rotations: &mut [[f32; 3]],
    out_gradients: &mut [[f32; 3]],
) -> Result<(), CallError> {
    envelope.check_stage(envelope.predictor().reconstructs())?;
    envelope.check_joints(pose)?;
    envelope.check_split(turns, Some(strains))?;
    Argument::Relative.check_len(4 * envelope.joint_len(), out_relative.len())?;
    Argument::Rotations.check_len(envelope.joint_len(), out_rotations.len())?;
    Argument::Gradients.check_len(3 * envelope.proxy_len(), out_gradients.len())?;
    let split = (turns, strains);
    envelope::rotational::gradients(
        envelope,
        pose,
        split,
        out_relative,
        out_rotations,
        out_gradients,
    );
    Ok(())
}

/// Stage palette: computes the palette from the results of [`gradients`].
///
/// - `root`: the root's skinning matrix B_r, which restores the root's motion: `T_l <- B_r T_l`.
/// - `relative`: the stack q, 4 J columns.
/// - `gradients`: the stack d, 3 P columns.
/// - `out_palette`: P transforms, rest to posed, in model space; `T_l[r][c]` is row 4 l + c of t.
///
/// # Errors
/// - [`crate::CallErrorKind::NoStage`]: the model uses the kernel predictor and has no c1 and c2.
/// - [`crate::CallErrorKind::Length`]: an argument has another length.
pub fn palette(
    envelope: &Envelope<'_>,
    root: &Matrix3x4,
    relative: &[[f32; 3]],
    gradients: &[[f32; 3]],
    out_palette: &mut [Matrix3x4],
) -> Result<(), CallError> {
    envelope.check_stage(envelope.predictor().reconstructs())?;
    Argument::Relative.check_len(4 * envelope.joint_len(), relative.len())?;
    Argument::Gradients.check_len(3 * envelope.proxy_len(), gradients.len())?;
    Argument::Palette.check_len(envelope.palette_len(), out_palette.len())?;
    envelope::rotational::palette(envelope, root, relative, gradients, out_palette);
    Ok(())
}

/// Stage joints: copies the joints' transforms into the palette, bit for bit, and copies the
/// dominant joint's transform for each helper.
///
/// - `pose`: J skinning matrices, rest to posed, in model space.
/// - `out_palette`: J + P transforms.
///
/// # Errors
/// - [`crate::CallErrorKind::NoStage`]: the model does not use the kernel predictor.
/// - [`crate::CallErrorKind::Length`]: an argument has another length.
/// - [`crate::CallErrorKind::NonFinite`]: a joint's matrix is not finite.
pub fn joints(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    out_palette: &mut [Matrix3x4],
) -> Result<(), CallError> {
    envelope.check_stage(!envelope.predictor().reconstructs())?;
    envelope.check_joints(pose)?;
    Argument::Palette.check_len(envelope.palette_len(), out_palette.len())?;
    envelope::helpers::joints(envelope, pose, out_palette);
    Ok(())
}

/// Stage features: computes the features phi of a pose, exactly 0 in the rest pose.
///
/// The first 12 J are those of the joints. Joint j with parent p turns by R relative to p. Its
/// features are the rows of `[S - I | gap]`. S rotates by half the angle of R (METHOD §1.9). The gap
/// leads from the joint's origin as p carries it to where it is, in the frame of p. Feature `12 j +
/// 4 r + c` is entry r, c; the root's features are 0.
///
/// If joints stretch, 6 J strains follow, and last the C curves.
///
/// - `pose`: J skinning matrices, rest to posed, in model space; [`crate::model_space_pose`] makes
///   them from local rotations.
/// - `curves`: C values.
/// - `turns`: from [`polar`]; empty if no joint stretches.
/// - `out_features`: [`envelope::EnvelopeCounts::feature_len`] values. The strains, which [`polar`]
///   writes, are left as they are.
///
/// # Errors
/// - [`crate::CallErrorKind::NoStage`]: the envelope is rotational and has no features.
/// - [`crate::CallErrorKind::Length`]: an argument has another length.
/// - [`crate::CallErrorKind::NonFinite`]: a joint's matrix or a curve is not finite.
pub fn features(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    curves: &[f32],
    turns: &[Columns],
    out_features: &mut [f32],
) -> Result<(), CallError> {
    let pose = Pose { joints: pose, curves };
    envelope.check_stage(envelope.predictor().corrects())?;
    envelope.check_finite(pose)?;
    envelope.check_split(turns, None)?;
    Argument::Features.check_len(envelope.counts().feature_len(), out_features.len())?;
    envelope::helpers::features(envelope, pose, turns, out_features);
    Ok(())
}

/// Stage correction: adds `Q_dom(l) K_l(phi)` to the transforms of the P proxies, and returns the
/// confidence in the pose.
///
/// The confidence is the smaller of two values: the groups' confidence and the confidence from the
/// trained ranges of joints and curves. Without groups the confidence is 1. Where a group's confidence is 0 its
/// proxies keep their bits.
///
/// - `pose`: J skinning matrices; Q is a joint's 3x3.
/// - `features`: phi, from [`features`].
/// - `scratch`: at least [`Envelope::correction_len`] floats, of any content.
/// - `out_palette`: [`Envelope::palette_len`] transforms. The correction is added to the last P.
///
/// # Errors
/// - [`crate::CallErrorKind::NoStage`]: the model is rotational and has no correction.
/// - [`crate::CallErrorKind::Length`]: `pose`, `features` or `out_palette` has another length.
/// - [`crate::CallErrorKind::TooShort`]: `scratch` is too short.
pub fn correction(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    features: &[f32],
    scratch: &mut [f32],
    out_palette: &mut [Matrix3x4],
) -> Result<f32, CallError> {
    envelope.check_stage(envelope.predictor().corrects())?;
    Argument::Pose.check_len(envelope.joint_len(), pose.len())?;
    Argument::Features.check_len(envelope.counts().feature_len(), features.len())?;
    Argument::Scratch.check_least(envelope.correction_len(), scratch.len())?;
    Argument::Palette.check_len(envelope.palette_len(), out_palette.len())?;
    if envelope.group_len() == 0 {
        return Ok(1.0);
    }
    Ok(envelope::helpers::correction(envelope, pose, features, scratch, out_palette))
}

/// Stage confidence: returns the least confidence over the joints of a rotational envelope.
///
/// A joint's confidence is 1 within its trained range and 0 from 1.5 times the range plus 0.1 rad
/// on, with a quintic step between. Strains count alike. A hidden joint has confidence 0.
///
/// - `pose`: J skinning matrices.
/// - `rotations`: J rotation vectors, from [`gradients`].
/// - `strains`: J strains, from [`polar`]; empty if no joint stretches.
///
/// # Errors
/// - [`crate::CallErrorKind::Length`]: an argument has another length.
pub fn confidence(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    rotations: &[[f32; 3]],
    strains: &[[f32; STRAIN_LEN]],
) -> Result<f32, CallError> {
    Argument::Pose.check_len(envelope.joint_len(), pose.len())?;
    Argument::Rotations.check_len(envelope.joint_len(), rotations.len())?;
    let expected = if envelope.stretches() { envelope.joint_len() } else { 0 };
    Argument::Strains.check_len(expected, strains.len())?;
    Ok(envelope::confidence::of_rotations(envelope, pose, rotations, strains))
}

impl Envelope<'_> {
    /// Checks the lengths of the results of stage polar.
    fn check_split(
        &self,
        turns: &[Columns],
        strains: Option<&[[f32; STRAIN_LEN]]>,
    ) -> Result<(), CallError> {
        let expected = if self.stretches() { self.joint_len() } else { 0 };
        Argument::Turns.check_len(expected, turns.len())?;
        strains.map_or(Ok(()), |strains| Argument::Strains.check_len(expected, strains.len()))
    }
}
