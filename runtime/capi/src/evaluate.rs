//! Each frame: from local transforms to a pose, to the palette, to bounds.

use crate::border::{self, Array};
use crate::{sinew_envelope, sinew_error, sinew_status, sinew_subject};
use core::mem::{align_of, offset_of, size_of};
use sinew_runtime::{Envelope, EvalError, LocalTransform, Matrix3x4, model_space_pose};

/// A rigid or affine map, as three rows of four: `y[r] = rows[r][0..2] . x + rows[r][3]`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_matrix {
    /// The rows.
    pub rows: [[f32; 4]; 3],
}

/// A joint's frame in its parent's.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_transform {
    /// Quaternion x, y, z, w; it is normalised by the call.
    pub rotation: [f32; 4],
    /// Origin in the parent's frame, in the units of the model.
    pub translation: [f32; 3],
}

/// A box along the axes, in model space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_bounds {
    /// Least coordinates.
    pub min: [f32; 3],
    /// Greatest coordinates.
    pub max: [f32; 3],
}

const _: () = {
    assert!(size_of::<sinew_matrix>() == size_of::<Matrix3x4>());
    assert!(align_of::<sinew_matrix>() == align_of::<Matrix3x4>());
    assert!(size_of::<sinew_transform>() == size_of::<LocalTransform>());
    assert!(align_of::<sinew_transform>() == align_of::<LocalTransform>());
    assert!(
        offset_of!(sinew_transform, translation) == offset_of!(LocalTransform, translation)
            && offset_of!(LocalTransform, rotation) == 0
    );
};

/// Computes the skinning matrices of a pose from local transforms and the hierarchy. An engine that
/// has skinning matrices (rest to posed, model space) does not need this.
///
/// - `local`, `local_len`: J transforms, the root's in model space.
/// - `out_pose`, `pose_len`: J matrices.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `LENGTH`, `NON_FINITE`, `ZERO_ROTATION`, `TOO_LONG`,
/// `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_pose(
    envelope: *const sinew_envelope,
    local: *const sinew_transform,
    local_len: usize,
    out_pose: *mut sinew_matrix,
    pose_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (envelope, [handle, file]) = unsafe { border::object(envelope) }?;
        let local = Array::new(local.cast::<LocalTransform>(), local_len, sinew_subject::Local)?;
        let out = Array::new(out_pose.cast::<Matrix3x4>(), pose_len, sinew_subject::Pose)?;
        border::apart(&[out.span()], &[handle, file, local.span()])?;
        local.check_len(envelope.joint_len())?;
        // SAFETY: lent by the caller; what is written is apart from all else.
        let (local, out) = unsafe { (local.read(), out.write()) };
        model_space_pose(envelope, local, out).map_err(|error| match error {
            EvalError::NonFinite { joint } => {
                sinew_error::new(sinew_status::NonFinite, sinew_subject::Local).at(joint)
            }
            other => other.into(),
        })
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Computes the palette of a pose and the confidence in it.
///
/// - `pose`, `pose_len`: J skinning matrices, rest to posed, in model space; rigid to 1e-4.
/// - `workspace`, `workspace_len`: at least `sinew_envelope_info.workspace_len` floats, of any
///   content; its content afterwards means nothing. One for each thread.
/// - `out_palette`, `palette_len`: `sinew_envelope_info.palette_len` maps, rest to posed, in model
///   space: for `sinew_skin`, or with `sinew_envelope_influences` for a shader.
/// - `out_confidence`: null, or receives 1 within what was seen in training down to 0 far from it.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`, `TOO_LONG`,
/// `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_palette(
    envelope: *const sinew_envelope,
    pose: *const sinew_matrix,
    pose_len: usize,
    workspace: *mut f32,
    workspace_len: usize,
    out_palette: *mut sinew_matrix,
    palette_len: usize,
    out_confidence: *mut f32,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let pose = Array::new(pose.cast(), pose_len, sinew_subject::Pose);
        let workspace = Array::new(workspace, workspace_len, sinew_subject::Workspace);
        let out = Array::new(out_palette.cast(), palette_len, sinew_subject::Palette);
        let evaluate = Envelope::palette;
        // SAFETY: the caller's promise is passed on.
        unsafe { palette(envelope, pose, workspace, out, out_confidence, evaluate) }
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Computes what `sinew_envelope_palette` does, with the same arguments, of a rotational model alone:
/// any other is `NO_STAGE`. A program that calls this and not the other is linked without kernel
/// maps: on a Cortex-M4F 6 kB less if optimised for size, 15 kB if for speed.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `NO_STAGE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`,
/// `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_rotational_palette(
    envelope: *const sinew_envelope,
    pose: *const sinew_matrix,
    pose_len: usize,
    workspace: *mut f32,
    workspace_len: usize,
    out_palette: *mut sinew_matrix,
    palette_len: usize,
    out_confidence: *mut f32,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let pose = Array::new(pose.cast(), pose_len, sinew_subject::Pose);
        let workspace = Array::new(workspace, workspace_len, sinew_subject::Workspace);
        let out = Array::new(out_palette.cast(), palette_len, sinew_subject::Palette);
        let evaluate = Envelope::rotational_palette;
        // SAFETY: the caller's promise is passed on.
        unsafe { palette(envelope, pose, workspace, out, out_confidence, evaluate) }
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Computes a box that holds every vertex of the posed skin, from the palette alone.
///
/// - `palette`, `palette_len`: `sinew_envelope_info.palette_len` maps.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `LENGTH`, `NO_VERTICES`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_bounds(
    envelope: *const sinew_envelope,
    palette: *const sinew_matrix,
    palette_len: usize,
    out_bounds: *mut sinew_bounds,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (envelope, [handle, file]) = unsafe { border::object(envelope) }?;
        let palette = Array::new(palette.cast::<Matrix3x4>(), palette_len, sinew_subject::Palette)?;
        let out = Array::one(out_bounds, sinew_subject::Result)?;
        border::apart(&[out.span()], &[handle, file, palette.span()])?;
        // SAFETY: lent by the caller.
        let bounds = envelope.bounds(unsafe { palette.read() })?;
        let bounds =
            bounds.ok_or(sinew_error::new(sinew_status::NoVertices, sinew_subject::Vertices))?;
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(sinew_bounds { min: bounds.min, max: bounds.max }) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Computes a palette by one of the runtime's ways.
///
/// # Safety
/// The handle is null or points to memory as large as an envelope; the arrays are the caller's to
/// read and to write, and so is what the confidence's pointer points to, if it is not null.
unsafe fn palette(
    envelope: *const sinew_envelope,
    pose: Result<Array<Matrix3x4>, sinew_error>,
    workspace: Result<Array<f32>, sinew_error>,
    out: Result<Array<Matrix3x4>, sinew_error>,
    out_confidence: *mut f32,
    evaluate: impl Fn(
        &Envelope<'static>,
        &[Matrix3x4],
        &mut [f32],
        &mut [Matrix3x4],
    ) -> Result<f32, EvalError>,
) -> Result<(), sinew_error> {
    // SAFETY: the caller's promise is passed on.
    let (envelope, [handle, file]) = unsafe { border::object(envelope) }?;
    let (pose, workspace, out) = (pose?, workspace?, out?);
    let out_confidence = Array::optional(out_confidence, sinew_subject::Result)?;
    border::apart(
        &[workspace.span(), out.span(), out_confidence.span()],
        &[handle, file, pose.span()],
    )?;
    // SAFETY: lent by the caller; what is written is apart from all else.
    let (pose, workspace, out) = unsafe { (pose.read(), workspace.write(), out.write()) };
    let confidence = evaluate(envelope, pose, workspace, out)?;
    // SAFETY: at most one element, lent by the caller.
    if let Some(out) = unsafe { out_confidence.write() }.first_mut() {
        *out = confidence;
    }
    Ok(())
}
