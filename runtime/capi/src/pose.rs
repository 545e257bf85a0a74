//! Poses of the caller's skeleton: binds joints and curves by name, gathers and checks poses, removes a scale.

use crate::argument::sinew_argument;
use crate::border::{self, Array, Span};
use crate::envelope::{SINEW_NO_JOINT, sinew_envelope, sinew_local_transform, sinew_matrix};
use crate::error::{sinew_error, sinew_status};
use crate::part;
use core::ffi::{CStr, c_char, c_void};
use sinew_runtime::envelope::{FOLDED, PoseFault, PoseFaultKind};
use sinew_runtime::{Envelope, LocalTransform, Matrix3x4, gather_pose, scale_palette, take_scale};

/// Entry of a joint map for a joint that the skeleton lacks. The joint moves with its parent.
pub const SINEW_FOLDED: u32 = u32::MAX;

const _: () = assert!(SINEW_FOLDED == FOLDED);

/// A name of the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_name {
    /// UTF-8; a terminating zero is not needed.
    pub name: *const c_char,
    /// Length of the name in bytes.
    pub name_len: usize,
}

/// Result of `sinew_envelope_bind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_bound_joints {
    /// Number of joints that the skeleton has; at least 1, the root.
    pub found_len: u32,
    /// First joint that the skeleton lacks although it has a child of that joint, or `SINEW_NO_JOINT`.
    pub missing_parent: u32,
}

/// Likely mistake in a pose that does not fit the skeleton.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum sinew_pose_fault_kind {
    /// No mistake: the pose fits the skeleton.
    None = 0,
    /// A matrix is not finite.
    NonFinite = 2,
    /// A matrix mirrors.
    Mirrored = 3,
    /// A matrix scales by `factor` along all axes.
    Scaled = 4,
    /// A matrix scales along axes by different factors, or shears, and further than in training.
    Stretched = 5,
    /// The matrices' rotations are transposed, and their translations may be lost.
    Transposed = 6,
    /// Lengths are in another unit. Multiply them by `factor` to get the model's unit.
    Units = 7,
    /// The pose uses other axes of the same handedness; `axes` lists them.
    Axes = 8,
    /// The pose uses axes of the other handedness; `axes` lists them.
    Handedness = 9,
    /// A joint is not where its parent carries it, and no mistake in the whole pose explains the distance.
    Apart = 10,
    /// The frames were not written: a matrix is zero, or all gathered frames are the identity.
    Unset = 11,
    /// The matrices are the joints' frames: the inverse bind matrices are missing.
    Frames = 12,
    /// The inverse bind matrices were applied twice.
    BoundTwice = 13,
    /// Each matrix, or each gathered frame, is relative to the joint's parent.
    Local = 14,
    /// A joint is hidden: its matrix is scaled to 0. Kernel maps take the joint as at rest.
    Hidden = 15,
    /// A curve is not finite, or far beyond its values in training.
    Curve = 17,
}

/// Result of `sinew_envelope_check_pose`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_pose_fault {
    /// Likely mistake. If there is none, all other fields are 0.
    pub kind: sinew_pose_fault_kind,
    /// Index of the joint or curve that shows the mistake.
    pub joint: u32,
    /// For a scale, its size. For units, the factor for the pose's lengths; 1 if the unit is right.
    pub factor: f32,
    /// Deviation of the joint: from a rotation, or from the place where its parent carries it. For a curve,
    /// its value.
    pub found: f32,
    /// Largest deviation that is allowed.
    pub allowed: f32,
    /// Axis of the pose for each axis of the model, counted from 1; negative if the direction is reversed.
    pub axes: [i32; 3],
}

/// Copies the rest frames of the J joints, each relative to its parent and the root's in model space. An
/// animation starts from these frames; `sinew_envelope_pose` makes the rest pose from them.
///
/// - `out_local`, `local_len`: room for J local transforms.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_rest_locals(
    envelope: *const sinew_envelope,
    out_local: *mut sinew_local_transform,
    local_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (envelope, reads) = unsafe { part::view(envelope) }?;
        let at = out_local.cast::<LocalTransform>();
        let out = Array::new(at, local_len, sinew_argument::Local)?;
        out.check_least(envelope.joint_len())?;
        border::check_disjoint(&[out.span()], &reads)?;
        // SAFETY: lent by the caller; the call reads no part of it.
        let out = unsafe { out.write() };
        out.iter_mut().zip(envelope.rest_locals()).for_each(|(out, local)| *out = local);
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Changes a name of the caller before it is compared with the file's names: returns a part of `name`, or
/// another name that stays valid during the call. For example it removes the prefix `mixamorig:`.
pub type sinew_rename =
    Option<unsafe extern "C" fn(name: sinew_name, user: *mut c_void) -> sinew_name>;

/// Finds the file's joints in the caller's skeleton by name, for `sinew_envelope_gather`. Names must be
/// equal. A joint that the skeleton lacks follows its parent: compare `found_len` of `out_bound` with the
/// envelope's `joint_len`.
///
/// - `names`, `names_len`: names of the skeleton's joints, in its order; more or fewer than the file's. The
///   first of equal names counts.
/// - `rename`, `user`: null, or a function that changes each name, called more than once for each name, and
///   its second argument.
/// - `out_map`, `map_len`: receives, for each of the J joints, the index of the skeleton's joint or
///   `SINEW_FOLDED`.
/// - `out_bound`: null, or receives how many joints were found.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `OTHER_NAME`, `NO_ROOT`, `NO_JOINTS`,
/// `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_bind(
    envelope: *const sinew_envelope,
    names: *const sinew_name,
    names_len: usize,
    rename: sinew_rename,
    user: *mut c_void,
    out_map: *mut u32,
    map_len: usize,
    out_bound: *mut sinew_bound_joints,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (envelope, [own, model, file]) = unsafe { part::view(envelope) }?;
        let names = Array::new(names, names_len, sinew_argument::Names)?;
        let out = Array::new(out_map, map_len, sinew_argument::Joints)?;
        let out_bound = Array::optional(out_bound, sinew_argument::Result)?;
        let written = [out.span(), out_bound.span()];
        border::check_disjoint(&written, &[own, model, file, names.span()])?;
        // SAFETY: lent by the caller; written memory does not overlap it.
        let names = unsafe { checked_names(names, &written) }?;
        // SAFETY: lent by the caller; overlaps nothing else.
        let out = unsafe { out.write() };
        let renamed = |name: &sinew_name| match rename {
            // SAFETY: the caller's function, which the caller lends with its argument.
            Some(rename) => unsafe { rename(*name, user) },
            None => *name,
        };
        // SAFETY: the names have been checked, or come from the caller's function.
        let names = names.iter().map(|name| unsafe { name_bytes(&renamed(name)) });
        let bound = envelope.bind_joints(names, out)?;
        let bound = sinew_bound_joints {
            found_len: bound.found_len as u32,
            missing_parent: bound.missing_parent.map_or(SINEW_NO_JOINT, |joint| joint as u32),
        };
        // SAFETY: one element or none, which the caller allows to be written.
        unsafe { out_bound.write() }.fill(bound);
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Finds the file's curves among the caller's by name. Names must be equal. The curves of a pose are
/// `curves[c] = values[out_map[c]]`.
///
/// - `names`, `names_len`: names of the caller's curves, in the order of `values`. The first of equal names
///   counts.
/// - `out_map`, `map_len`: receives, for each of the C curves, the index of the caller's curve.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `NO_CURVE`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_bind_curves(
    envelope: *const sinew_envelope,
    names: *const sinew_name,
    names_len: usize,
    out_map: *mut u32,
    map_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (envelope, [own, model, file]) = unsafe { part::view(envelope) }?;
        let names = Array::new(names, names_len, sinew_argument::Names)?;
        let out = Array::new(out_map, map_len, sinew_argument::Curves)?;
        let written = [out.span()];
        border::check_disjoint(&written, &[own, model, file, names.span()])?;
        // SAFETY: lent by the caller; written memory does not overlap it.
        let names = unsafe { checked_names(names, &written) }?;
        // SAFETY: lent by the caller; overlaps nothing else.
        let out = unsafe { out.write() };
        // SAFETY: the names have been checked.
        Ok(envelope.bind_curves(names.iter().map(|name| unsafe { name_bytes(name) }), out)?)
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Gathers the J skinning matrices of a pose from the frames of the caller's skeleton, after its hierarchy
/// pass. Matrix j is `root * world[map[j]] * inverse_bind_j`. A folded joint has its parent's matrix.
///
/// - `map`, `map_len`: J indices from `sinew_envelope_bind`.
/// - `world`, `world_len`: frames of the skeleton's joints, all in one space and in the model's unit.
/// - `root`: null, or the matrix from that space to the space of the palette.
/// - `out_pose`, `pose_len`: receives J matrices.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `NO_ROOT`, `NON_FINITE`,
/// `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_gather(
    envelope: *const sinew_envelope,
    map: *const u32,
    map_len: usize,
    world: *const sinew_matrix,
    world_len: usize,
    root: *const sinew_matrix,
    out_pose: *mut sinew_matrix,
    pose_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (envelope, [own, model, file]) = unsafe { part::view(envelope) }?;
        let map = Array::new(map, map_len, sinew_argument::Joints)?;
        let world = Array::new(world.cast::<Matrix3x4>(), world_len, sinew_argument::World)?;
        let root = Array::optional(root.cast::<Matrix3x4>(), sinew_argument::Root)?;
        let out = Array::new(out_pose.cast::<Matrix3x4>(), pose_len, sinew_argument::Pose)?;
        let reads = [own, model, file, map.span(), world.span(), root.span()];
        border::check_disjoint(&[out.span()], &reads)?;
        // SAFETY: lent by the caller; written memory overlaps nothing else.
        let (map, world, root, out) =
            unsafe { (map.read(), world.read(), root.read(), out.write()) };
        Ok(gather_pose(&envelope, map, world, root.first(), out)?)
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Checks, for debug builds, that a pose fits the skeleton. Each matrix must be a rotation and a
/// translation, but a joint may stretch twice as far as in training. Each joint must be where its parent
/// carries it, within twice the distances seen in training. A curve may be ten times as large as in
/// training. A pose that does not fit is not an error of the call; `out_fault` names the likely mistake.
///
/// A pose that fits takes a few microseconds; finding the mistake takes milliseconds.
///
/// - `pose`, `pose_len`, `curves`, `curves_len`: as for `sinew_envelope_palette`.
/// - `out_fault`: receives the likely mistake, or `SINEW_POSE_FAULT_KIND_NONE`.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_check_pose(
    envelope: *const sinew_envelope,
    pose: *const sinew_matrix,
    pose_len: usize,
    curves: *const f32,
    curves_len: usize,
    out_fault: *mut sinew_pose_fault,
    out_error: *mut sinew_error,
) -> sinew_status {
    let pose = Array::new(pose.cast(), pose_len, sinew_argument::Pose);
    let curves = Array::new(curves, curves_len, sinew_argument::Curves);
    let answer = |envelope: &Envelope<'_>, pose: &[Matrix3x4], curves: &[f32]| {
        check_len(sinew_argument::Pose, envelope.joint_len(), pose.len())?;
        check_len(sinew_argument::Curves, envelope.curve_len(), curves.len())?;
        Ok(envelope.check_pose(pose, curves).map_or_else(sinew_pose_fault::from, |()| NO_FAULT))
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { part::compute(envelope, (pose, curves), out_fault, out_error, answer) }
}

/// Returns the remedy for a mistake in a pose as zero-terminated text. Other numbers give "unknown
/// mistake". The pointer is never null and stays valid.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_pose_fault_text(kind: u32) -> *const c_char {
    let found = REMEDIES.iter().find(|(known, _)| *known as u32 == kind);
    found.map_or(c"unknown mistake", |(_, text)| text).as_ptr()
}

/// Removes the scale that all joints of a pose share, for example that of a scaled actor.
/// `sinew_palette_scale` applies the scale to the palette.
///
/// The scale is read from the first joint, and must be uniform: the columns of that joint's 3x3 are equally
/// long and at right angles, within 2e-3 of the squared length. Otherwise, and for an empty pose or a scale
/// within 4e-6 of 1, the result is 1 and the pose stays unchanged.
///
/// - `pose`, `pose_len`: skinning matrices; they are changed.
/// - `out_scale`: receives the scale.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_pose_take_scale(
    pose: *mut sinew_matrix,
    pose_len: usize,
    out_scale: *mut f32,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let pose = Array::new(pose.cast::<Matrix3x4>(), pose_len, sinew_argument::Pose)?;
        let out = Array::one(out_scale, sinew_argument::Result)?;
        border::check_disjoint(&[pose.span(), out.span()], &[])?;
        // SAFETY: lent by the caller; the memory of the scale does not overlap it.
        let scale = take_scale(unsafe { pose.write() });
        // SAFETY: one element, which the caller allows to be written.
        unsafe { out.store(scale) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Scales the result of a palette about the origin of model space, by the scale that was removed from the
/// pose. Normals and tangents need no change.
///
/// - `palette`, `palette_len`: transforms; they are changed.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_LONG`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_palette_scale(
    palette: *mut sinew_matrix,
    palette_len: usize,
    scale: f32,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let at = palette.cast::<Matrix3x4>();
        let palette = Array::new(at, palette_len, sinew_argument::Palette)?;
        // SAFETY: lent by the caller.
        scale_palette(unsafe { palette.write() }, scale);
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Computes the hash of a skeleton, to compare with `sinew_envelope_info.skeleton_hash`. FORMAT.md defines
/// the hash.
///
/// - `names`, `parents`, `joint_len`: names and parents of the joints, in the file's order;
///   `SINEW_NO_JOINT` for no parent.
/// - `out_hash`: receives the hash.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skeleton_hash(
    names: *const sinew_name,
    parents: *const u32,
    joint_len: usize,
    out_hash: *mut u32,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let names = Array::new(names, joint_len, sinew_argument::Names)?;
        let parents = Array::new(parents, joint_len, sinew_argument::Joints)?;
        let out = Array::one(out_hash, sinew_argument::Result)?;
        border::check_disjoint(&[out.span()], &[names.span(), parents.span()])?;
        // SAFETY: lent by the caller; written memory does not overlap it.
        let (names, parents) = unsafe { (checked_names(names, &[out.span()])?, parents.read()) };
        // SAFETY: the names have been checked.
        let names = names.iter().map(|name| unsafe { name_bytes(name) });
        let parents = parents.iter().map(|parent| usize::try_from(*parent).ok());
        let hash = sinew_runtime::skeleton_hash_of(names, parents);
        // SAFETY: one element, which the caller allows to be written.
        unsafe { out.store(hash) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Checks the length of an array.
pub(crate) fn check_len(
    argument: sinew_argument,
    expected: usize,
    found: usize,
) -> Result<(), sinew_error> {
    if found == expected {
        return Ok(());
    }
    Err(sinew_error::new(sinew_status::Length, argument).values(expected, found))
}

/// Borrows names after checking their pointers and lengths, and that written memory does not overlap their bytes.
///
/// # Safety
/// For `'a` the caller keeps the names and their bytes readable and unchanged.
unsafe fn checked_names<'a>(
    names: Array<sinew_name>,
    written: &[Span],
) -> Result<&'a [sinew_name], sinew_error> {
    // SAFETY: the caller's promise is passed on.
    let names = unsafe { names.read() };
    for (index, name) in names.iter().enumerate() {
        let text = Array::new(name.name.cast::<u8>(), name.name_len, sinew_argument::Names);
        let text = text.map_err(|error| error.at(index))?;
        border::check_disjoint(written, &[text.span()])?;
    }
    Ok(names)
}

/// Borrows the bytes of a name.
///
/// # Safety
/// The pointer and the length have been checked. For `'a` the caller keeps the bytes unchanged.
unsafe fn name_bytes<'a>(name: &sinew_name) -> &'a [u8] {
    if name.name_len == 0 || name.name.is_null() {
        return &[];
    }
    // SAFETY: not null, and of a length that fits; the rest is the caller's promise.
    unsafe { core::slice::from_raw_parts(name.name.cast(), name.name_len) }
}

/// Answer for a pose without a fault.
const NO_FAULT: sinew_pose_fault = sinew_pose_fault {
    kind: sinew_pose_fault_kind::None,
    joint: 0,
    factor: 0.0,
    found: 0.0,
    allowed: 0.0,
    axes: [0; 3],
};

/// Remedy for each mistake.
const REMEDIES: [(sinew_pose_fault_kind, &CStr); 16] = {
    use sinew_pose_fault_kind as K;
    [
        (K::None, c"nothing: the pose fits the skeleton"),
        (K::NonFinite, c"not finite: check the source of the joint's matrix"),
        (K::Mirrored, c"mirrored: take the mirror out of the actor and put it on the palette"),
        (K::Scaled, c"scaled: sinew_pose_take_scale takes out a scale that all joints share"),
        (
            K::Stretched,
            c"scaled unevenly or sheared: drop both, or train on poses that stretch the joint so far",
        ),
        (K::Transposed, c"transposed: a matrix is three rows, the translation in the last column"),
        (K::Units, c"in another unit: convert the pose, or bake the model with --to-unit"),
        (
            K::Axes,
            c"in other axes: convert the pose, or bake the model with --to-up and --to-forward",
        ),
        (
            K::Handedness,
            c"of the other handedness: convert the pose, or bake the model with --to-hand",
        ),
        (
            K::Apart,
            c"off its parent: check its parent and its inverse bind matrix, or train on such poses",
        ),
        (K::Unset, c"not set: write the skeleton's frames before gathering the pose"),
        (
            K::Frames,
            c"frames without inverse bind matrices: sinew_envelope_gather applies the matrices",
        ),
        (
            K::BoundTwice,
            c"inverse bind matrices applied twice: give sinew_envelope_gather the joints' frames",
        ),
        (K::Local, c"relative to the parents: chain local transforms with sinew_envelope_pose"),
        (K::Hidden, c"scaled to 0: show the joint, or skip the check for poses that hide joints"),
        (
            K::Curve,
            c"a curve far beyond training: give it in the unit of training, a percentage divided by 100",
        ),
    ]
};

impl From<PoseFault> for sinew_pose_fault {
    fn from(fault: PoseFault) -> Self {
        let PoseFault { kind, joint, factor, found, allowed, axes } = fault;
        use sinew_pose_fault_kind as K;
        let kind = match kind {
            // The call has refused arrays of another length.
            PoseFaultKind::Length | PoseFaultKind::CurveLength => K::None,
            PoseFaultKind::NonFinite => K::NonFinite,
            PoseFaultKind::Mirrored => K::Mirrored,
            PoseFaultKind::Scaled => K::Scaled,
            PoseFaultKind::Stretched => K::Stretched,
            PoseFaultKind::Transposed => K::Transposed,
            PoseFaultKind::Units => K::Units,
            PoseFaultKind::Axes => K::Axes,
            PoseFaultKind::Handedness => K::Handedness,
            PoseFaultKind::Apart => K::Apart,
            PoseFaultKind::Unset => K::Unset,
            PoseFaultKind::Frames => K::Frames,
            PoseFaultKind::BoundTwice => K::BoundTwice,
            PoseFaultKind::Local => K::Local,
            PoseFaultKind::Hidden => K::Hidden,
            PoseFaultKind::Curve => K::Curve,
        };
        Self { kind, joint: joint as u32, factor, found, allowed, axes: axes.map(i32::from) }
    }
}
