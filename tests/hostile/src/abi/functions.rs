//! Every function that can fail, with the arguments that it takes.

use super::arena::{Arena, bytes, floats};
use super::call::Call;
use arbitrary::Result;
use sinew_capi::*;
use sinew_runtime::format::Predictor;
use std::ffi::c_char;
use std::ptr::{null, null_mut};

/// Draws a function's arguments and calls it.
pub(super) type Function = fn(&mut Call<'_, '_>) -> Result<sinew_status>;

/// The functions by their names.
pub(super) const FUNCTIONS: [(&str, Function); 17] = [
    ("sinew_limits_default", limits_default),
    ("sinew_model_load", load),
    ("sinew_model_blob", blob),
    ("sinew_model_section", section),
    ("sinew_envelope_open", open),
    ("sinew_envelope_describe", describe),
    ("sinew_envelope_joint", joint),
    ("sinew_envelope_order", order),
    ("sinew_envelope_pose", pose),
    ("sinew_envelope_palette", palette),
    ("sinew_envelope_rotational_palette", rotational_palette),
    ("sinew_envelope_bounds", bounds),
    ("sinew_envelope_rest_positions", rest_positions),
    ("sinew_envelope_rest_normals", rest_normals),
    ("sinew_envelope_rest_tangents", rest_tangents),
    ("sinew_envelope_influences", influences),
    ("sinew_skin", skin),
];

/// Nothing that this module compares: the C ABI's own tests do.
fn unknown(_: &Arena) -> Vec<u8> {
    Vec::new()
}

fn limits_default(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let out = call.output_one()?;
    let error = call.ready(unknown);
    // SAFETY: as for each call of this module: pointers are null, misaligned, or into the arena, with
    // lengths that stay within it or reach beyond the address space; handles are null, misaligned, or
    // point to enough of it, where an object is loaded or the memory is blank.
    Ok(unsafe { sinew_limits_default(out, error) })
}

fn load(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    call.faultless &= call.arena.blob().is_some();
    let (memory, memory_bytes) = call.memory(sinew_model_bytes())?;
    let (file, file_bytes) = call.input_any(call.arena.file.clone())?;
    let limits = if call.one_in(4)? { limits(call)? } else { null() };
    let out = call.output_one()?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_model_load(memory, memory_bytes, file, file_bytes, limits, out, error) })
}

/// Draws limits, some of which the file may exceed.
fn limits(call: &mut Call<'_, '_>) -> Result<*const sinew_limits> {
    let place = call.arena.argument.start;
    let mut limits = [0; 5];
    for limit in &mut limits {
        *limit = if call.one_in(4)? { call.any()? } else { u32::MAX };
    }
    call.arena.write(place, limits.map(u32::to_ne_bytes).as_flattened());
    call.input_one(place)
}

fn blob(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (model, out, out_bytes) = (call.model()?, call.output_one()?, call.output_one()?);
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_model_blob(model, out, out_bytes, error) })
}

fn section(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (model, part, kind, out) = (call.model()?, call.any()?, call.any()?, call.output_one()?);
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_model_section(model, part, kind, out, error) })
}

fn open(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let model = call.model()?;
    call.faultless &= call.arena.info().is_some();
    let (name, name_len) = if call.one_in(2)? { name(call)? } else { (null(), 0) };
    let (memory, memory_bytes) = call.memory(sinew_envelope_bytes())?;
    let out = call.output_one()?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_envelope_open(model, name, name_len, memory, memory_bytes, out, error) })
}

/// Draws the envelope's name, or bytes that are none.
fn name(call: &mut Call<'_, '_>) -> Result<(*const c_char, usize)> {
    let start = call.arena.argument.start;
    let mut name = call.arena.frame.name.clone().into_bytes();
    if call.one_in(4)? {
        name.reverse();
        call.faultless = false;
    }
    call.arena.write(start, &name);
    call.input_any(start..start + name.len())
}

fn describe(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (envelope, out) = (call.envelope()?, call.output_one()?);
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_envelope_describe(envelope, out, error) })
}

fn joint(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let envelope = call.envelope()?;
    let joint = call.number(call.arena.frame.pose.len())?;
    let out = call.output_one()?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_envelope_joint(envelope, joint, out, error) })
}

fn order(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let envelope = call.envelope()?;
    let (out, out_len) = call.output(call.arena.frame.pose.len())?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_envelope_order(envelope, out, out_len, error) })
}

fn pose(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    call.spoil(call.arena.local.clone())?;
    let envelope = call.envelope()?;
    let (local, local_len) = call.input(call.arena.local.clone())?;
    let (out, out_len) = call.output_exact(call.arena.frame.pose.len())?;
    let error = call.ready(|arena| bytes(floats(&arena.frame.pose)));
    // SAFETY: as above.
    Ok(unsafe { sinew_envelope_pose(envelope, local, local_len, out, out_len, error) })
}

fn palette(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    palette_by(call, sinew_envelope_palette)
}

fn rotational_palette(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let is_rotational = call.arena.frame.predictor == Some(Predictor::Rotational);
    call.faultless &= is_rotational;
    call.must_fail |= !is_rotational;
    palette_by(call, sinew_envelope_rotational_palette)
}

/// What computes a palette.
type PaletteCall = unsafe extern "C" fn(
    *const sinew_envelope,
    *const sinew_matrix,
    usize,
    *mut f32,
    usize,
    *mut sinew_matrix,
    usize,
    *mut f32,
    *mut sinew_error,
) -> sinew_status;

fn palette_by(call: &mut Call<'_, '_>, function: PaletteCall) -> Result<sinew_status> {
    call.spoil(call.arena.pose.clone())?;
    let envelope = call.envelope()?;
    let (pose, pose_len) = call.input(call.arena.pose.clone())?;
    let (out, out_len) = call.output_exact(call.arena.frame.palette.len())?;
    let (scratch, scratch_len) = call.output(call.arena.frame.workspace_len)?;
    let confidence = if call.one_in(4)? { null_mut() } else { call.output_one()? };
    let error = call.ready(|arena| bytes(floats(&arena.frame.palette)));
    // SAFETY: as above.
    Ok(unsafe {
        function(envelope, pose, pose_len, scratch, scratch_len, out, out_len, confidence, error)
    })
}

fn bounds(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    call.faultless &= call.arena.frame.bounds.is_some();
    let envelope = call.envelope()?;
    let (palette, palette_len) = call.input(call.arena.palette.clone())?;
    let out = call.output_one()?;
    let error = call.ready(|arena| {
        bytes(arena.frame.bounds.into_iter().flat_map(|bounds| [bounds.min, bounds.max]).flatten())
    });
    // SAFETY: as above.
    Ok(unsafe { sinew_envelope_bounds(envelope, palette, palette_len, out, error) })
}

fn rest_positions(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    rest(call, 3, sinew_envelope_rest_positions)
}

fn rest_normals(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    rest(call, 3, sinew_envelope_rest_normals)
}

fn rest_tangents(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    call.faultless &= call.arena.frame.has_tangents;
    rest(call, 4, sinew_envelope_rest_tangents)
}

/// What copies an attribute of the rest pose.
type RestCall = unsafe extern "C" fn(
    *const sinew_envelope,
    usize,
    usize,
    *mut f32,
    usize,
    *mut sinew_error,
) -> sinew_status;

fn rest(call: &mut Call<'_, '_>, floats: usize, function: RestCall) -> Result<sinew_status> {
    let (envelope, (start, end, n)) = (call.envelope()?, call.vertices()?);
    let (out, out_len) = call.output(floats * n)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { function(envelope, start, end, out, out_len, error) })
}

fn influences(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (envelope, (start, end, n)) = (call.envelope()?, call.vertices()?);
    let len = n * call.arena.frame.influence_len;
    let (indices, indices_len) = call.output(len)?;
    let (weights, weights_len) = call.output(len)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe {
        sinew_envelope_influences(
            envelope,
            start,
            end,
            indices,
            indices_len,
            weights,
            weights_len,
            error,
        )
    })
}

fn skin(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    call.spoil(call.arena.palette.clone())?;
    let envelope = call.envelope()?;
    let (palette, palette_len) = call.input(call.arena.palette.clone())?;
    let (start, end, _) = call.vertices()?;
    let (stride, whole) = (call.arena.frame.stride(), call.arena.frame.skin.len());
    let (out_a, out_a_len) = call.output_any(whole)?;
    let (out_b, out_b_len) =
        if call.one_in(4)? { call.output_any(whole)? } else { (null_mut(), 0) };
    let positions = attribute(call, Some(0))?;
    let normals = attribute(call, Some(3))?;
    let tangents = attribute(call, Some(6).filter(|_| call.arena.frame.has_tangents))?;
    let place = call.arena.argument.start;
    let job = call.arena.at::<sinew_skin_job>(place);
    // SAFETY: the place is aligned and large enough. Field by field leaves the padding as it was.
    unsafe {
        (*job).envelope = envelope;
        ((*job).palette, (*job).palette_len) = (palette, palette_len);
        ((*job).start, (*job).end) = (start, end);
        for (at, from) in [
            (&raw mut (*job).positions, positions),
            (&raw mut (*job).normals, normals),
            (&raw mut (*job).tangents, tangents),
        ] {
            ((*at).buffer, (*at).offset, (*at).stride) = (from.buffer, from.offset, from.stride);
        }
        ((*job).out_a, (*job).out_a_len) = (out_a, out_a_len);
        ((*job).out_b, (*job).out_b_len) = (out_b, out_b_len);
    }
    // Any other bytes would be pointers to no memory of the caller.
    let job = call.input_fixed(place)?;
    let error = call.ready(|arena| {
        let skin = arena.frame.skin.get(stride * start..stride * end);
        bytes(skin.into_iter().flatten().copied())
    });
    // SAFETY: as above.
    Ok(unsafe { sinew_skin(job, error) })
}

/// Draws where an attribute goes: to its offset in buffer A, to none where it has no offset, or
/// astray.
fn attribute(call: &mut Call<'_, '_>, offset: Option<usize>) -> Result<sinew_attribute> {
    if call.one_in(8)? {
        let stride = call.number(call.arena.frame.stride() + 1)?;
        let offset = call.number(call.arena.frame.skin.len() + 1)?;
        return Ok(sinew_attribute { buffer: call.any()? % 4, offset, stride });
    }
    let stride = call.arena.frame.stride();
    Ok(match offset {
        Some(offset) => sinew_attribute { buffer: sinew_buffer::A as u32, offset, stride },
        None => sinew_attribute { buffer: sinew_buffer::None as u32, offset: 0, stride: 0 },
    })
}
