//! Calls about a pose of the caller's skeleton: gather, check, scale, levels.

use super::call::Call;
use super::shared::{
    one_curves, one_pose, optional, optional_input, spoilt_curves, spoilt_pose, unknown,
};
use arbitrary::Result;
use sinew_capi::*;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::{Envelope, Model};
use std::ops::Range;
use std::ptr::{null, null_mut};

use sinew_argument as Argument;
use sinew_status as Status;

pub(super) fn rest_locals(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let envelope = call.envelope()?;
    let (out, out_len) = call.output(call.arena.frame.pose.len(), Argument::Local)?;
    let error = call.ready(unknown);
    // SAFETY: as for each call of `functions`; names also point into the arena.
    Ok(unsafe { sinew_envelope_rest_locals(envelope, out, out_len, error) })
}

pub(super) fn bones(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let envelope = call.envelope()?;
    let (all, p) = (call.arena.frame.palette.len(), call.arena.frame.proxy_len);
    // A skin of another envelope has a palette of another length.
    let place = call.arena.skin_palette.clone();
    let (palette, palette_len) = call.input(place, all, Argument::Palette)?;
    let (out, out_len) = call.output_exact(p, p, Argument::Bones)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_envelope_bones(envelope, palette, palette_len, out, out_len, error) })
}

pub(super) fn bind(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let envelope = call.envelope()?;
    let j = call.arena.frame.pose.len();
    let own = joint_names(call.arena.file_bytes());
    let (names, names_len) = names(call, own, j)?;
    // The root may be among the names that are not found.
    call.maybe_faulty = true;
    let (out, out_len) = call.output_exact(j, j, Argument::Joints)?;
    let bound = optional(call, Argument::Result)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe {
        sinew_envelope_bind(
            envelope,
            names,
            names_len,
            None,
            null_mut(),
            out,
            out_len,
            bound,
            error,
        )
    })
}

pub(super) fn bind_curves(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let envelope = call.envelope()?;
    let c = call.arena.frame.curves.len();
    let own = curve_names(call.arena.file_bytes());
    let (names, names_len) = names(call, own, c)?;
    // A curve may be missing among the names.
    call.maybe_faulty = true;
    let (out, out_len) = call.output_exact(c, c, Argument::Curves)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_envelope_bind_curves(envelope, names, names_len, out, out_len, error) })
}

pub(super) fn gather(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (envelope, j) = (call.envelope()?, call.arena.frame.pose.len());
    // The joint's frame, or a missing joint, or a joint that makes the map singular.
    let place = call.arena.local.start;
    let mut map: Vec<u32> = (0..j as u32).collect();
    let one = if j > 0 { call.u.choose_index(j)? } else { 0 };
    if let Some(one) = map.get_mut(one) {
        *one = *call.u.choose(&[0, 1, j as u32, SINEW_FOLDED - 1, SINEW_FOLDED])?;
    }
    let content: Vec<u8> = map.iter().flat_map(|number| number.to_ne_bytes()).collect();
    call.arena.write(place, &content);
    call.spoil(call.arena.poses.clone())?;
    call.maybe_faulty = true;
    let (map, map_len) = call.input::<u32>(place..place + content.len(), j, Argument::Joints)?;
    let (world, world_len) = call.input_any(call.arena.poses.clone(), Argument::World)?;
    let root: *const sinew_matrix = match j {
        0 => null(),
        _ => optional_input(call, call.arena.poses.start, Argument::Root)?,
    };
    let (out, out_len) = call.output_exact(j, j, Argument::Pose)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe {
        sinew_envelope_gather(envelope, map, map_len, world, world_len, root, out, out_len, error)
    })
}

pub(super) fn check_pose(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (one, curves) = (one_pose(call), one_curves(call));
    for place in [&one, &curves] {
        if call.one_in(2)? && !place.is_empty() {
            // A fault of the pose is not a fault of the call.
            let at = place.start + 4 * call.u.choose_index(place.len() / 4)?;
            call.arena.write(at, &call.u.arbitrary::<f32>()?.to_ne_bytes());
        }
    }
    let (envelope, j) = (call.envelope()?, call.arena.frame.pose.len());
    let (pose, pose_len) = call.input(one, j, Argument::Pose)?;
    let c = call.arena.frame.curves.len();
    let (curves, curves_len) = call.input(curves, c, Argument::Curves)?;
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe {
        sinew_envelope_check_pose(envelope, pose, pose_len, curves, curves_len, out, error)
    })
}

pub(super) fn take_scale(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (pose, len) = call.output_any(call.arena.frame.pose.len(), Argument::Pose)?;
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_pose_take_scale(pose, len, out, error) })
}

pub(super) fn palette_scale(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (palette, len) = call.output_any(call.arena.frame.palette.len(), Argument::Palette)?;
    let scale = call.u.arbitrary()?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_palette_scale(palette, len, scale, error) })
}

pub(super) fn base_palette(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let one = spoilt_pose(call)?;
    let (curves, curves_len) = spoilt_curves(call)?;
    let (envelope, j) = (call.envelope()?, call.arena.frame.pose.len());
    let (pose, pose_len) = call.input(one, j, Argument::Pose)?;
    let p = call.arena.frame.palette.len();
    let (out, out_len) = call.output_exact(p, p, Argument::Palette)?;
    let (scratch, scratch_len) = call.output(call.arena.frame.scratch_len, Argument::Scratch)?;
    let confidence =
        if call.one_in(4)? { null_mut() } else { optional(call, Argument::Confidences)? };
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe {
        sinew_envelope_base_palette(
            envelope,
            pose,
            pose_len,
            curves,
            curves_len,
            scratch,
            scratch_len,
            out,
            out_len,
            confidence,
            error,
        )
    })
}

pub(super) fn joint_confidences(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let one = spoilt_pose(call)?;
    let (curves, curves_len) = spoilt_curves(call)?;
    let (envelope, j) = (call.envelope()?, call.arena.frame.pose.len());
    let is_rotational = call.arena.frame.predictor == Some(Predictor::Rotational);
    call.fault_if(is_rotational, Status::NoStage, Argument::Call);
    let (pose, pose_len) = call.input(one, j, Argument::Pose)?;
    let (out, out_len) = call.output_exact(j, j, Argument::Confidences)?;
    let (scratch, scratch_len) = call.output(call.arena.frame.scratch_len, Argument::Scratch)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe {
        sinew_envelope_joint_confidences(
            envelope,
            pose,
            pose_len,
            curves,
            curves_len,
            scratch,
            scratch_len,
            out,
            out_len,
            error,
        )
    })
}

pub(super) fn skeleton_hash(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (own, j) = (joint_names(call.arena.file_bytes()), call.arena.frame.pose.len());
    let (names, len) = names(call, own, j)?;
    let place = call.arena.poses.start;
    call.read.push(place..place + 4 * len);
    let parents = if len == 0 { null() } else { call.input_fixed(place, Argument::Joints)? };
    let out = call.output_one(Argument::Result)?;
    // More names than any address leaves room for.
    let is_too_long = len > 0 && call.one_in(8)?;
    call.fault_if(is_too_long, Status::TooLong, Argument::Names);
    let len = if is_too_long { usize::MAX / 4 } else { len };
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_skeleton_hash(names, parents, len, out, error) })
}

pub(super) fn skin_mesh_hash(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (skin, out) = (call.skin()?, call.output_one(Argument::Result)?);
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_skin_mesh_hash(skin, out, error) })
}

pub(super) fn mesh_hash(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let place = call.arena.rest[0].clone();
    let (positions, len) = call.input_any::<[f32; 3]>(place, Argument::RestPositions)?;
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_mesh_hash(positions.cast(), len, out, error) })
}

/// Draws at most `most` names: some of `own` names of the file, a name with a prefix, pieces of the
/// file, or a name at a wrong address.
fn names(
    call: &mut Call<'_, '_>,
    own: Vec<Range<usize>>,
    most: usize,
) -> Result<(*const sinew_name, usize)> {
    let (place, file) = (call.arena.names.start, call.arena.file.clone());
    let len = if call.one_in(8)? { most.min(1) } else { call.u.int_in_range(0..=most)? };
    let mut content = Vec::new();
    let mut own = if call.one_in(2)? { own } else { Vec::new() };
    if len == 1 && own.len() > 1 {
        // One name alone, which may be that of the root.
        let one = call.u.choose_index(own.len())?;
        own.swap(0, one);
    }
    let other = if call.one_in(4)? { call.u.int_in_range(0..=len)? } else { len };
    for number in 0..len {
        let (start, name_len) = match own.get(number) {
            Some(name) if number == other => prefixed(call, name.clone()),
            Some(name) => (file.start + name.start, name.len()),
            None => {
                let start = call.u.int_in_range(file.start..=file.end)?;
                (start, call.u.int_in_range(0..=8)?.min(file.end - start))
            }
        };
        let at = if call.one_in(32)? { null() } else { call.arena.at::<u8>(start).cast_const() };
        call.fault_if(at.is_null() && name_len > 0, Status::Null, Argument::Names);
        if !at.is_null() {
            call.read.push(start..start + name_len);
        }
        content.extend(at.expose_provenance().to_ne_bytes());
        content.extend(name_len.to_ne_bytes());
    }
    call.arena.write(place, &content);
    call.read.push(place..place + content.len());
    // Other bytes would be pointers to memory that the caller does not own.
    let names = if len == 0 { null() } else { call.input_fixed(place, Argument::Names)? };
    Ok((names, len))
}

/// Writes a name of the file with a prefix behind the poses. Returns its place and length; returns
/// the original name if there is no room.
fn prefixed(call: &mut Call<'_, '_>, name: Range<usize>) -> (usize, usize) {
    let (file, poses) = (call.arena.file.start, call.arena.poses.clone());
    let text = [b"rig:", &call.arena.file_bytes()[name.clone()]].concat();
    if text.len() > poses.len() {
        return (file + name.start, name.len());
    }
    let start = poses.end - text.len();
    call.arena.write(start, &text);
    (start, text.len())
}

/// Finds the places of the joints' names in a file.
fn joint_names(file: &[u8]) -> Vec<Range<usize>> {
    places(file, |envelope| {
        (0..envelope.joint_len()).filter_map(|joint| envelope.joint_name(joint)).collect()
    })
}

/// Finds the places of the curves' names in a file.
fn curve_names(file: &[u8]) -> Vec<Range<usize>> {
    places(file, |envelope| {
        (0..envelope.curve_len()).filter_map(|curve| envelope.curve_name(curve)).collect()
    })
}

/// Finds the places of some names of the first envelope in a file.
fn places(file: &[u8], names: impl FnOnce(Envelope<'_>) -> Vec<&str>) -> Vec<Range<usize>> {
    let Ok(model) = Model::from_bytes(file) else { return Vec::new() };
    let Some(envelope) = model.first::<Envelope>() else { return Vec::new() };
    let start = |name: &str| name.as_ptr().addr() - file.as_ptr().addr();
    names(envelope).into_iter().map(|name| start(name)..start(name) + name.len()).collect()
}
