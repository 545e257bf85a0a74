//! A pose of the caller's skeleton: gathered by names, checked, its scale taken out.

use crate::argument::sinew_argument;
use crate::border::{self, Array, Span};
use crate::envelope::{SINEW_NO_JOINT, sinew_envelope, sinew_local_transform, sinew_matrix};
use crate::error::{sinew_error, sinew_status};
use crate::part;
use core::ffi::{CStr, c_char};
use sinew_runtime::envelope::{FOLDED, PoseFault, PoseFaultKind};
use sinew_runtime::{LocalTransform, Matrix3x4, gather_pose, scale_palette, take_scale};

/// Stands in a joint map for a joint that the skeleton lacks: it moves as its parent does.
pub const SINEW_FOLDED: u32 = u32::MAX;

const _: () = assert!(SINEW_FOLDED == FOLDED);

/// A name of the caller's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_name {
    /// UTF-8; no zero at its end is needed.
    pub name: *const c_char,
    /// Bytes of the name.
    pub name_len: usize,
}

/// What `sinew_envelope_bind` found of the file's joints in a skeleton.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_bound_joints {
    /// Number of joints that the skeleton has, at least the root.
    pub found_len: u32,
    /// First joint that the skeleton lacks although it has the joint's child, or `SINEW_NO_JOINT`.
    pub missing_parent: u32,
}

/// The likely mistake of a pose that is none of the skeleton's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum sinew_pose_fault_kind {
    /// None: the pose is one of the skeleton's.
    None = 0,
    /// A matrix is not finite.
    NonFinite = 2,
    /// A matrix mirrors.
    Mirrored = 3,
    /// A matrix scales by `factor` along all axes.
    Scaled = 4,
    /// A matrix scales along axes by different factors, or shears.
    Stretched = 5,
    /// The matrices' rotations are transposed, and their translations may be lost.
    Transposed = 6,
    /// Lengths are in another unit: `factor` of them make one of the model's.
    Units = 7,
    /// The pose is in other axes of the same handedness, `axes`.
    Axes = 8,
    /// The pose is in axes of the other handedness, `axes`.
    Handedness = 9,
    /// A joint is off the place to which its parent carries it, and no mistake about the whole pose explains it.
    Apart = 10,
    /// No frame was written: a matrix is zero, or all gathered frames are the identity.
    Unset = 11,
    /// The matrices are the joints' frames: the inverse bind matrices were not applied.
    Frames = 12,
    /// The inverse bind matrices were applied twice.
    BoundTwice = 13,
    /// Each matrix, or each gathered frame, is in the space of the joint's parent.
    Local = 14,
}

/// What `sinew_envelope_check_pose` found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_pose_fault {
    /// The likely mistake; all else is 0 where there is none.
    pub kind: sinew_pose_fault_kind,
    /// The joint that shows it.
    pub joint: u32,
    /// Of a scale how large it is; of units what to multiply the pose's lengths by, 1 where they are right.
    pub factor: f32,
    /// How far the joint is from what it may be: off a rotation, or off the place to which its parent carries it.
    pub found: f32,
    /// How far it may be.
    pub allowed: f32,
    /// Which axis of the pose each axis of the model is, from 1 and negative where it is turned round.
    pub axes: [i32; 3],
}

/// Copies the J joints' rest frames, each in its parent's, the root's in model space: what an animation changes, and
/// of what `sinew_envelope_pose` makes the rest pose.
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
        border::apart(&[out.span()], &reads)?;
        // SAFETY: apart from all that the call reads; lent by the caller.
        let out = unsafe { out.write() };
        out.iter_mut().zip(envelope.rest_locals()).for_each(|(out, local)| *out = local);
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Finds the file's joints in a skeleton of the caller's, for `sinew_envelope_gather`. Names must be equal. A joint
/// that the skeleton lacks follows its parent: compare `found_len` of `out_bound` with the envelope's `joint_len`.
///
/// - `names`, `names_len`: of the skeleton's joints, in its order; more than the file has, or fewer. Of two
///   of one name the first counts.
/// - `out_map`, `map_len`: receive for each of the J joints the number of the skeleton's, or `SINEW_FOLDED`.
/// - `out_bound`: null, or receives how many joints were found.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `OTHER_NAME`, `NO_ROOT`, `NO_JOINTS`, `TOO_LONG`,
/// `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_bind(
    envelope: *const sinew_envelope,
    names: *const sinew_name,
    names_len: usize,
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
        border::apart(&written, &[own, model, file, names.span()])?;
        // SAFETY: lent by the caller, and apart from what is written.
        let names = unsafe { checked(names, &written) }?;
        // SAFETY: apart from all else; lent by the caller.
        let out = unsafe { out.write() };
        // SAFETY: the names have been checked.
        let bound = envelope.bind_joints(names.iter().map(|name| unsafe { bytes(name) }), out)?;
        let bound = sinew_bound_joints {
            found_len: bound.found_len as u32,
            missing_parent: bound.missing_parent.map_or(SINEW_NO_JOINT, |joint| joint as u32),
        };
        // SAFETY: one element or none, which the caller lets be written.
        unsafe { out_bound.write() }.fill(bound);
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Gathers the J skinning matrices of a pose from the frames of the caller's skeleton after its hierarchy pass:
/// matrix j is `root * world[map[j]] * inverse_bind_j`; a joint that is folded has its parent's.
///
/// - `map`, `map_len`: J numbers, as `sinew_envelope_bind` gives them.
/// - `world`, `world_len`: the frames, all in one space and in the unit of the model.
/// - `root`: null, or carries that space to the one in which the palette is wanted.
/// - `out_pose`, `pose_len`: J matrices.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `OUT_OF_RANGE`, `NO_ROOT`, `NON_FINITE`,
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
        border::apart(&[out.span()], &reads)?;
        // SAFETY: lent by the caller; what is written is apart from all else.
        let (map, world, root, out) =
            unsafe { (map.read(), world.read(), root.read(), out.write()) };
        Ok(gather_pose(&envelope, map, world, root.first(), out)?)
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Checks for a debug build that a pose is one of the skeleton's: that each matrix turns and moves only, and that each
/// joint is where its parent carries it, as far as it was in training. A pose that is not is no error of the
/// call: `out_fault` says what is likely wrong. A pose is taken in a few microseconds; naming a mistake takes
/// milliseconds.
///
/// - `pose`, `pose_len`: J skinning matrices, rest to posed, in model space.
/// - `out_fault`: receives the likely mistake, or that there is none.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_check_pose(
    envelope: *const sinew_envelope,
    pose: *const sinew_matrix,
    pose_len: usize,
    out_fault: *mut sinew_pose_fault,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (envelope, [own, model, file]) = unsafe { part::view(envelope) }?;
        let pose = Array::new(pose.cast::<Matrix3x4>(), pose_len, sinew_argument::Pose)?;
        let out = Array::one(out_fault, sinew_argument::Result)?;
        border::apart(&[out.span()], &[own, model, file, pose.span()])?;
        // SAFETY: lent by the caller, and apart from what is written.
        let pose = unsafe { pose.read() };
        if pose.len() != envelope.joint_len() {
            let error = sinew_error::new(sinew_status::Length, sinew_argument::Pose);
            return Err(error.values(envelope.joint_len(), pose.len()));
        }
        let fault = envelope.check_pose(pose).map_or_else(sinew_pose_fault::from, |()| SOUND);
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(fault) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Returns what to do about the mistake of a pose, in a few words that end in a zero; of any other number, that it is
/// unknown. Never null, valid for ever.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_pose_fault_text(kind: u32) -> *const c_char {
    let found = REMEDIES.iter().find(|(known, _)| *known as u32 == kind);
    found.map_or(c"unknown mistake", |(_, text)| text).as_ptr()
}

/// Takes out of a pose the scale that all its joints share, as that of a scaled actor; what is left is rigid.
/// `sinew_palette_scale` puts it back on the palette. It is read off the first joint; none, or one within 4e-6 of 1, is
/// given as 1, and the pose keeps its bits.
///
/// - `pose`, `pose_len`: skinning matrices, which are changed.
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
        border::apart(&[pose.span(), out.span()], &[])?;
        // SAFETY: lent by the caller, and apart from where the scale goes.
        let scale = take_scale(unsafe { pose.write() });
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(scale) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Scales what a palette makes of its vertices, about the origin of model space: a scale that was taken out of the
/// pose. Normals and tangents need nothing more.
///
/// - `palette`, `palette_len`: transforms, which are changed.
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

/// Computes the hash of a skeleton, to compare with `sinew_envelope_info.skeleton_hash`; FORMAT.md says what it is
/// of.
///
/// - `names`, `parents`, `joint_len`: of the joints, in the file's order; `SINEW_NO_JOINT` for no parent.
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
        border::apart(&[out.span()], &[names.span(), parents.span()])?;
        // SAFETY: lent by the caller, and apart from what is written.
        let (names, parents) = unsafe { (checked(names, &[out.span()])?, parents.read()) };
        // SAFETY: the names have been checked.
        let names = names.iter().map(|name| unsafe { bytes(name) });
        let parents = parents.iter().map(|parent| usize::try_from(*parent).ok());
        let hash = sinew_runtime::skeleton_hash_of(names, parents);
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(hash) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Refers to names whose pointers and lengths are right, and which lie apart from what is written.
///
/// # Safety
/// For `'a` the caller keeps the names, and what they point to, readable and unchanged.
unsafe fn checked<'a>(
    names: Array<sinew_name>,
    written: &[Span],
) -> Result<&'a [sinew_name], sinew_error> {
    // SAFETY: the caller's promise is passed on.
    let names = unsafe { names.read() };
    for (index, name) in names.iter().enumerate() {
        let text = Array::new(name.name.cast::<u8>(), name.name_len, sinew_argument::Names);
        let text = text.map_err(|error| error.at(index))?;
        border::apart(written, &[text.span()])?;
    }
    Ok(names)
}

/// Refers to the bytes of a name.
///
/// # Safety
/// Its pointer and its length have been checked, and for `'a` the caller keeps the bytes as they are.
unsafe fn bytes<'a>(name: &sinew_name) -> &'a [u8] {
    if name.name_len == 0 {
        return &[];
    }
    // SAFETY: not null, and of a length that fits; the rest is the caller's promise.
    unsafe { core::slice::from_raw_parts(name.name.cast(), name.name_len) }
}

/// What is said of a pose without a fault.
const SOUND: sinew_pose_fault = sinew_pose_fault {
    kind: sinew_pose_fault_kind::None,
    joint: 0,
    factor: 0.0,
    found: 0.0,
    allowed: 0.0,
    axes: [0; 3],
};

/// What to do about each mistake.
const REMEDIES: [(sinew_pose_fault_kind, &CStr); 14] = {
    use sinew_pose_fault_kind as K;
    [
        (K::None, c"nothing: the pose is one of the skeleton's"),
        (K::NonFinite, c"not finite: look where the joint's matrix comes from"),
        (K::Mirrored, c"mirrored: take the mirror out of the actor and put it on the palette"),
        (K::Scaled, c"scaled: sinew_pose_take_scale takes out a scale that all joints share"),
        (K::Stretched, c"scaled unevenly or sheared: joints only turn and move"),
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
            c"off its parent: look at its parent and its inverse bind matrix, or train such poses",
        ),
        (K::Unset, c"not set: write the skeleton's frames before the pose is made of them"),
        (
            K::Frames,
            c"frames without inverse bind matrices: sinew_envelope_gather multiplies by them",
        ),
        (
            K::BoundTwice,
            c"inverse bind matrices applied twice: give sinew_envelope_gather the joints' frames",
        ),
        (K::Local, c"in the parents' spaces: chain local transforms with sinew_envelope_pose"),
    ]
};

impl From<PoseFault> for sinew_pose_fault {
    fn from(fault: PoseFault) -> Self {
        let PoseFault { kind, joint, factor, found, allowed, axes } = fault;
        use sinew_pose_fault_kind as K;
        let kind = match kind {
            // A pose of another length is a call's error.
            PoseFaultKind::Length => K::None,
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
        };
        Self { kind, joint: joint as u32, factor, found, allowed, axes: axes.map(i32::from) }
    }
}
