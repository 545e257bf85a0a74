//! Envelopes and matrices: opens and describes an envelope, its joints and its curves.

use crate::argument::sinew_argument;
use crate::border::Loaded;
use crate::error::{sinew_error, sinew_status};
use crate::part::{self, Opened};
use core::ffi::c_char;
use core::mem::{align_of, offset_of, size_of};
use sinew_runtime::envelope::{HelperKind, Predictor};
use sinew_runtime::{Envelope, LocalTransform, Matrix3x4};

/// Sentinel for "no joint", for example the root's parent.
pub const SINEW_NO_JOINT: u32 = u32::MAX;

/// Predicts a palette of transforms from the J joints and C curves of a pose.
///
/// The envelope points to its model. Every call refuses the envelope once the model was cleared or has
/// loaded another file.
pub struct sinew_envelope(Loaded<Opened>);

part::part! { sinew_envelope: Envelope, tag b"SnwE", argument Envelope }

/// A rigid or affine transform in three rows of four: `y[r] = rows[r][0..2] . x + rows[r][3]`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_matrix {
    /// The rows.
    pub rows: [[f32; 4]; 3],
}

const _: () = {
    assert!(size_of::<sinew_matrix>() == size_of::<Matrix3x4>());
    assert!(align_of::<sinew_matrix>() == align_of::<Matrix3x4>());
};

/// Frame of a joint, relative to its parent's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_local_transform {
    /// Quaternion x, y, z, w; calls normalise it.
    pub rotation: [f32; 4],
    /// Origin in the parent's frame, in the model's unit.
    pub translation: [f32; 3],
}

/// A helper as a bone of an engine, in model space: `y = translation + rotation (scale * (x - centre))`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_bone {
    /// Translation, in the model's unit.
    pub translation: [f32; 3],
    /// Unit quaternion x, y, z, w.
    pub rotation: [f32; 4],
    /// Scale along the model's axes at rest. All three are negative if the transform mirrors.
    pub scale: [f32; 3],
    /// Centre of the vertices that the helper moves, at rest. The bone's rest frame is the translation to the
    /// centre, its bind matrix the translation back; they are the same in every pose.
    pub centre: [f32; 3],
}

const _: () = {
    assert!(size_of::<sinew_local_transform>() == size_of::<LocalTransform>());
    assert!(align_of::<sinew_local_transform>() == align_of::<LocalTransform>());
    assert!(
        offset_of!(sinew_local_transform, translation) == offset_of!(LocalTransform, translation)
            && offset_of!(LocalTransform, rotation) == 0
    );
};

/// How an envelope predicts its palette.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum sinew_predictor {
    /// Rotational regression. The palette holds P proxies.
    Rotational = 1,
    /// Kernel maps. The palette holds the J joints, then P helpers, which the maps move.
    Kernel = 2,
}

/// Transforms that the helpers of an envelope may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum sinew_helper_kind {
    /// Any affine transform.
    Affine = 0,
    /// Translation, rotation and scale along the model's axes at rest, as bones of engines hold them.
    Trs = 1,
    /// Translation and rotation.
    Rigid = 2,
}

/// Measured errors of the fit, in the unit of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_certificate {
    /// Diagonal of the rest pose's box.
    pub diagonal: f32,
    /// RMS error over vertices and training frames.
    pub training_rms: f32,
    /// Forecast of the RMS error on unseen frames of the training clips.
    pub same_clips_rms: f32,
    /// RMS error of linear blend skinning over vertices and training frames.
    pub lbs_training_rms: f32,
    /// Largest displacement of a vertex by rounding of the correction; 0 without a correction.
    pub correction_error: f32,
    /// RMS error of `sinew_envelope_base_palette` over vertices and training frames.
    pub base_training_rms: f32,
    /// Forecast of the RMS error on an unseen clip; negative if training had one clip.
    pub other_clip_rms: f32,
    /// Largest distance that a vertex moves if helpers become bones of translation, rotation and scale, over the
    /// training frames.
    pub trs_error: f32,
}

/// Counts of an envelope, and the lengths of all arrays that its calls take.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_envelope_info {
    /// Name in UTF-8, in the file's bytes, without a terminating zero.
    pub name: *const c_char,
    /// Length of the name in bytes.
    pub name_len: usize,
    /// Index among the file's parts.
    pub part: u32,
    /// How the envelope predicts.
    pub predictor: sinew_predictor,
    /// J, the number of joints: skinning matrices of a pose.
    pub joint_len: usize,
    /// C, the number of curves: floats of a pose; 0 for a rotational envelope.
    pub curve_len: usize,
    /// P, the number of proxies or helpers.
    pub proxy_len: usize,
    /// Number of transforms of the palette.
    pub palette_len: usize,
    /// Floats of scratch that `sinew_envelope_palette` needs.
    pub scratch_len: usize,
    /// Index of the joint without a parent; 0 if there is no joint.
    pub root: u32,
    /// Hash of names and parents, as `sinew_skeleton_hash` computes it.
    pub skeleton_hash: u32,
    /// 1 if a joint stretches, otherwise 0.
    pub stretches: u32,
    /// Transforms that the helpers may have; affine for a rotational envelope.
    pub helper_kind: sinew_helper_kind,
    /// Measured errors of the fit.
    pub certificate: sinew_certificate,
}

/// A joint of an envelope.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_joint {
    /// Name in UTF-8, in the file's bytes, without a terminating zero.
    pub name: *const c_char,
    /// Length of the name in bytes.
    pub name_len: usize,
    /// Index of the parent, or `SINEW_NO_JOINT`.
    pub parent: u32,
    /// Largest angle in training between the joint's rotation relative to its parent and its rest rotation,
    /// in radians.
    pub pose_range: f32,
    /// Largest distance in training between the joint's origin and the place where its parent carries it.
    pub pose_gap: f32,
    /// Largest strain in training: the norm of `(L^T L - I) / 2`, where L is the 3x3 of the joint's matrix.
    /// It is 0 if the joint does not stretch.
    pub stretch_range: f32,
    /// Inverse bind matrix: model space to the joint's rest frame.
    pub inverse_bind: sinew_matrix,
    /// Rest frame relative to the parent; for the root, in model space.
    pub rest_local: sinew_local_transform,
}

/// A curve of an envelope: a number of the animation, for example a slider of the rig. At rest a curve is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_curve {
    /// Name in UTF-8, in the file's bytes, without a terminating zero.
    pub name: *const c_char,
    /// Length of the name in bytes.
    pub name_len: usize,
    /// Smallest value in training.
    pub min: f32,
    /// Largest value in training.
    pub max: f32,
}

/// Describes an envelope.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_describe(
    envelope: *const sinew_envelope,
    out_info: *mut sinew_envelope_info,
    out_error: *mut sinew_error,
) -> sinew_status {
    // SAFETY: the caller's promise is passed on.
    unsafe { part::describe(envelope, out_info, out_error, |envelope| Ok(info(envelope))) }
}

/// Describes a joint.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`, `OUT_OF_RANGE`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_joint(
    envelope: *const sinew_envelope,
    joint: usize,
    out_joint: *mut sinew_joint,
    out_error: *mut sinew_error,
) -> sinew_status {
    let answer = |envelope: &Envelope<'_>| {
        let outside = sinew_error::out_of_range(sinew_argument::Joint, joint, envelope.joint_len());
        joint_info(envelope, joint).ok_or(outside)
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { part::describe(envelope, out_joint, out_error, answer) }
}

/// Describes a curve.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`, `OUT_OF_RANGE`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_curve(
    envelope: *const sinew_envelope,
    curve: usize,
    out_curve: *mut sinew_curve,
    out_error: *mut sinew_error,
) -> sinew_status {
    let answer = |envelope: &Envelope<'_>| {
        let outside = sinew_error::out_of_range(sinew_argument::Curve, curve, envelope.curve_len());
        curve_info(envelope, curve).ok_or(outside)
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { part::describe(envelope, out_curve, out_error, answer) }
}

fn info(envelope: &Envelope<'_>) -> sinew_envelope_info {
    let certificate = envelope.certificate();
    sinew_envelope_info {
        name: envelope.name().as_ptr().cast(),
        name_len: envelope.name().len(),
        part: envelope.part() as u32,
        predictor: match envelope.predictor() {
            Predictor::Rotational => sinew_predictor::Rotational,
            Predictor::Kernel => sinew_predictor::Kernel,
        },
        joint_len: envelope.joint_len(),
        curve_len: envelope.curve_len(),
        proxy_len: envelope.proxy_len(),
        palette_len: envelope.palette_len(),
        scratch_len: envelope.scratch_len(),
        root: envelope.root() as u32,
        skeleton_hash: envelope.skeleton_hash(),
        stretches: u32::from(envelope.stretches()),
        helper_kind: match envelope.helper_kind() {
            HelperKind::Affine => sinew_helper_kind::Affine,
            HelperKind::Trs => sinew_helper_kind::Trs,
            HelperKind::Rigid => sinew_helper_kind::Rigid,
        },
        certificate: sinew_certificate {
            diagonal: certificate.diagonal,
            training_rms: certificate.training_rms,
            same_clips_rms: certificate.same_clips_rms,
            lbs_training_rms: certificate.lbs_training_rms,
            correction_error: certificate.correction_error,
            base_training_rms: certificate.base_training_rms,
            other_clip_rms: certificate.other_clip_rms.unwrap_or(-1.0),
            trs_error: certificate.trs_error,
        },
    }
}

fn joint_info(envelope: &Envelope<'_>, joint: usize) -> Option<sinew_joint> {
    let name = envelope.joint_name(joint)?;
    let LocalTransform { rotation, translation } = envelope.rest_local(joint)?;
    Some(sinew_joint {
        name: name.as_ptr().cast(),
        name_len: name.len(),
        parent: envelope.parent(joint).map_or(SINEW_NO_JOINT, |parent| parent as u32),
        pose_range: envelope.pose_range(joint)?,
        pose_gap: envelope.pose_gap(joint)?,
        stretch_range: envelope.stretch_range(joint)?,
        inverse_bind: sinew_matrix { rows: envelope.inverse_bind(joint)? },
        rest_local: sinew_local_transform { rotation, translation },
    })
}

fn curve_info(envelope: &Envelope<'_>, curve: usize) -> Option<sinew_curve> {
    let name = envelope.curve_name(curve)?;
    let [min, max] = envelope.curve_range(curve)?;
    Some(sinew_curve { name: name.as_ptr().cast(), name_len: name.len(), min, max })
}
