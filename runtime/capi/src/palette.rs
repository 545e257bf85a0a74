//! Per-frame calls: local transforms to a pose, and a pose to a palette.

use crate::argument::sinew_argument;
use crate::border::Array;
use crate::envelope::{sinew_bone, sinew_envelope, sinew_local_transform, sinew_matrix};
use crate::error::{sinew_error, sinew_status};
use crate::part::Evaluation;
use crate::pose::check_len;
use sinew_runtime::envelope::Trs;
use sinew_runtime::{Envelope, LocalTransform, Matrix3x4, model_space_pose};

/// Computes the skinning matrices of a pose from local transforms and the hierarchy. An engine that already
/// has skinning matrices (rest to posed, model space) does not need this call.
///
/// - `local`, `local_len`: J local transforms; the root's is in model space.
/// - `out_pose`, `pose_len`: receives J matrices.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `NON_FINITE`, `ZERO_ROTATION`,
/// `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_pose(
    envelope: *const sinew_envelope,
    local: *const sinew_local_transform,
    local_len: usize,
    out_pose: *mut sinew_matrix,
    pose_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let evaluation = Evaluation::<LocalTransform, Matrix3x4> {
        input: Array::new(local.cast(), local_len, sinew_argument::Local),
        curves: Array::none(),
        scratch: Array::none(),
        output: Array::new(out_pose.cast(), pose_len, sinew_argument::Pose),
        confidences: Array::none(),
    };
    // SAFETY: the caller's promise is passed on.
    unsafe {
        evaluation.run(envelope, out_error, |envelope, local, _, _, out, _| {
            model_space_pose(envelope, local, out)
        })
    }
}

/// Computes the palette of a pose and its confidence.
///
/// - `pose`, `pose_len`: J skinning matrices, rest to posed, in model space. The matrix of a joint whose
///   `sinew_joint.stretch_range` is 0 must be rigid to 1e-4. This call does not check the matrices; in debug
///   builds use `sinew_envelope_check_pose`.
/// - `curves`, `curves_len`: C values, in the order of `sinew_envelope_curve` and in the unit of training. A
///   model without curves takes null and 0.
/// - `scratch`, `scratch_len`: at least `sinew_envelope_info.scratch_len` floats with any content, one
///   array per thread. The content after the call has no meaning.
/// - `out_palette`, `palette_len`: receives `sinew_envelope_info.palette_len` transforms, rest to posed, in
///   model space. They are for `sinew_skin_run`, or with `sinew_skin_influences` for a shader.
/// - `out_confidence`: null, or receives the confidence: 1 inside the trained range, falling to 0 far
///   outside. A joint that is scaled to 0 or mirrored gives 0.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`, `TOO_LONG`,
/// `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_palette(
    envelope: *const sinew_envelope,
    pose: *const sinew_matrix,
    pose_len: usize,
    curves: *const f32,
    curves_len: usize,
    scratch: *mut f32,
    scratch_len: usize,
    out_palette: *mut sinew_matrix,
    palette_len: usize,
    out_confidence: *mut f32,
    out_error: *mut sinew_error,
) -> sinew_status {
    let evaluation = Evaluation::<Matrix3x4, Matrix3x4> {
        input: Array::new(pose.cast(), pose_len, sinew_argument::Pose),
        curves: Array::new(curves, curves_len, sinew_argument::Curves),
        scratch: Array::new(scratch, scratch_len, sinew_argument::Scratch),
        output: Array::new(out_palette.cast(), palette_len, sinew_argument::Palette),
        confidences: Array::optional(out_confidence, sinew_argument::Confidences),
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { evaluation.run_one(envelope, out_error, Envelope::palette) }
}

/// Splits the transforms of the helpers of a palette, or of the proxies of a rotational envelope, into
/// translation, rotation and scale, for engines whose bones hold these. A bone loses the shear of its transform;
/// `sinew_certificate.trs_error` states what that costs, and `sinew train --helper-kind trs` makes helpers without
/// shear. Bones of a helper that is nearly flat or 0 have the identity rotation.
///
/// - `palette`, `palette_len`: the result of `sinew_envelope_palette`.
/// - `out_bones`, `bones_len`: receives `sinew_envelope_info.proxy_len` bones. The joints are bones of the
///   engine's own skeleton.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_bones(
    envelope: *const sinew_envelope,
    palette: *const sinew_matrix,
    palette_len: usize,
    out_bones: *mut sinew_bone,
    bones_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let evaluation = Evaluation::<Matrix3x4, sinew_bone> {
        input: Array::new(palette.cast(), palette_len, sinew_argument::Palette),
        curves: Array::none(),
        scratch: Array::none(),
        output: Array::new(out_bones, bones_len, sinew_argument::Bones),
        confidences: Array::none(),
    };
    let split = |envelope: &Envelope<'_>,
                 palette: &[Matrix3x4],
                 out: &mut [sinew_bone]|
     -> Result<(), sinew_error> {
        check_len(sinew_argument::Palette, envelope.palette_len(), palette.len())?;
        check_len(sinew_argument::Bones, envelope.proxy_len(), out.len())?;
        let helpers = palette.iter().skip(palette.len() - out.len());
        for (helper, (out, entry)) in out.iter_mut().zip(helpers).enumerate() {
            if let (Some(bone), Some(centre)) =
                (envelope.bone(helper, entry), envelope.helper_centre(helper))
            {
                let Trs { translation, rotation, scale } = bone;
                *out = sinew_bone { translation, rotation, scale, centre };
            }
        }
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe {
        evaluation.run(envelope, out_error, |envelope, palette, _, _, out, _| {
            split(envelope, palette, out)
        })
    }
}

/// Computes the base of the palette, for a character that is far away: `sinew_envelope_palette` without the
/// correction, with the arguments of that call.
///
/// The base of a kernel envelope is its joints, which cost almost nothing. The base of a rotational envelope
/// is its reconstruction, which is the whole work. `sinew_certificate.base_training_rms` is the error.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`, `TOO_LONG`,
/// `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_base_palette(
    envelope: *const sinew_envelope,
    pose: *const sinew_matrix,
    pose_len: usize,
    curves: *const f32,
    curves_len: usize,
    scratch: *mut f32,
    scratch_len: usize,
    out_palette: *mut sinew_matrix,
    palette_len: usize,
    out_confidence: *mut f32,
    out_error: *mut sinew_error,
) -> sinew_status {
    let evaluation = Evaluation::<Matrix3x4, Matrix3x4> {
        input: Array::new(pose.cast(), pose_len, sinew_argument::Pose),
        curves: Array::new(curves, curves_len, sinew_argument::Curves),
        scratch: Array::new(scratch, scratch_len, sinew_argument::Scratch),
        output: Array::new(out_palette.cast(), palette_len, sinew_argument::Palette),
        confidences: Array::optional(out_confidence, sinew_argument::Confidences),
    };
    // SAFETY: the caller's promise is passed on.
    unsafe {
        evaluation.run_one(envelope, out_error, |envelope, input, curves, scratch, output| {
            envelope.base_palette(input, curves, scratch, output)
        })
    }
}

/// Computes the confidence of each joint in a pose, from the kernel maps that move its skin and from its
/// trained range. The result shows which part of the skin the confidence of `sinew_envelope_palette` is
/// about. A rotational envelope has no such confidences: `NO_STAGE`.
///
/// - `pose`, `pose_len`, `curves`, `curves_len`, `scratch`, `scratch_len`: as for `sinew_envelope_palette`.
/// - `out_confidences`, `confidences_len`: receives J values in [0, 1]. If no map moves a joint's skin,
///   only the trained range counts. An envelope without maps gives 1.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `NO_STAGE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`,
/// `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_joint_confidences(
    envelope: *const sinew_envelope,
    pose: *const sinew_matrix,
    pose_len: usize,
    curves: *const f32,
    curves_len: usize,
    scratch: *mut f32,
    scratch_len: usize,
    out_confidences: *mut f32,
    confidences_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let evaluation = Evaluation::<Matrix3x4, Matrix3x4> {
        input: Array::new(pose.cast(), pose_len, sinew_argument::Pose),
        curves: Array::new(curves, curves_len, sinew_argument::Curves),
        scratch: Array::new(scratch, scratch_len, sinew_argument::Scratch),
        output: Array::none(),
        confidences: Array::new(out_confidences, confidences_len, sinew_argument::Confidences),
    };
    // SAFETY: the caller's promise is passed on.
    unsafe {
        evaluation.run(envelope, out_error, |envelope, input, curves, scratch, _, out| {
            envelope.joint_confidences(input, curves, scratch, out)
        })
    }
}

/// Computes the palettes of a batch of poses. Each palette has the bits of `sinew_envelope_palette`.
///
/// - `poses`, `poses_len`: J skinning matrices per pose, one pose after another.
/// - `curves`, `curves_len`: C values per pose.
/// - `scratch`, `scratch_len`: as for one pose.
/// - `out_palettes`, `palettes_len`: receives `sinew_envelope_info.palette_len` transforms per pose.
/// - `out_confidences`, `confidences_len`: receives one confidence per pose. Their number sets the number
///   of poses.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`, `TOO_LONG`,
/// `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_palettes(
    envelope: *const sinew_envelope,
    poses: *const sinew_matrix,
    poses_len: usize,
    curves: *const f32,
    curves_len: usize,
    scratch: *mut f32,
    scratch_len: usize,
    out_palettes: *mut sinew_matrix,
    palettes_len: usize,
    out_confidences: *mut f32,
    confidences_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let evaluation = Evaluation::<Matrix3x4, Matrix3x4> {
        input: Array::new(poses.cast(), poses_len, sinew_argument::Pose),
        curves: Array::new(curves, curves_len, sinew_argument::Curves),
        scratch: Array::new(scratch, scratch_len, sinew_argument::Scratch),
        output: Array::new(out_palettes.cast(), palettes_len, sinew_argument::Palette),
        confidences: Array::new(out_confidences, confidences_len, sinew_argument::Confidences),
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { evaluation.run(envelope, out_error, Envelope::palettes) }
}

/// Computes the palette as `sinew_envelope_palette` does, but only of a rotational envelope, which has no
/// curves; other envelopes give `NO_STAGE`. A program that calls only this function links no kernel maps:
/// on a Cortex-M4F this saves 6 kB if optimised for size, 9 kB if for speed.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `NO_STAGE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`,
/// `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_rotational_palette(
    envelope: *const sinew_envelope,
    pose: *const sinew_matrix,
    pose_len: usize,
    scratch: *mut f32,
    scratch_len: usize,
    out_palette: *mut sinew_matrix,
    palette_len: usize,
    out_confidence: *mut f32,
    out_error: *mut sinew_error,
) -> sinew_status {
    let evaluation = Evaluation::<Matrix3x4, Matrix3x4> {
        input: Array::new(pose.cast(), pose_len, sinew_argument::Pose),
        curves: Array::none(),
        scratch: Array::new(scratch, scratch_len, sinew_argument::Scratch),
        output: Array::new(out_palette.cast(), palette_len, sinew_argument::Palette),
        confidences: Array::optional(out_confidence, sinew_argument::Confidences),
    };
    // SAFETY: the caller's promise is passed on.
    unsafe {
        evaluation.run_one(envelope, out_error, |envelope, input, _, scratch, output| {
            envelope.rotational_palette(input, scratch, output)
        })
    }
}
