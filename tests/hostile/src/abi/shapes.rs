//! The shape functions and their arguments.

use super::arena::{BLANK, bytes};
use super::call::Call;
use super::shared::{FLOATS, outputs, unknown};
use arbitrary::Result;
use sinew_capi::*;

use sinew_argument as Argument;
use sinew_status as Status;

pub(super) fn shape(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let skin = call.skin()?;
    let shape = call.number(call.arena.frame.weights.len(), Argument::Shape)?;
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(unknown);
    // SAFETY: as for each call of `functions`.
    Ok(unsafe { sinew_skin_shape(skin, shape, out, error) })
}

/// Draws weights: the frame's, or the frame's with one NaN.
fn weights(call: &mut Call<'_, '_>) -> Result<(*const f32, usize)> {
    let (place, len) = (call.arena.weights.clone(), call.arena.frame.weights.len());
    let is_spoilt = call.one_in(8)? && len > 0;
    if is_spoilt {
        call.arena.write(place.start, &f32::NAN.to_ne_bytes());
    }
    let (weights, weights_len) = call.input::<f32>(place.clone(), len, Argument::ShapeWeights)?;
    // An array at another place does not contain the NaN.
    let is_read = is_spoilt && weights == call.arena.at::<f32>(place.start).cast_const();
    call.fault_if(is_read, Status::NonFinite, Argument::ShapeWeights);
    Ok((weights, weights_len))
}

pub(super) fn run(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let skin = call.skin()?;
    let (weights, weights_len) = weights(call)?;
    let (start, end, n) = call.vertices(call.arena.frame.vertex_len)?;
    let (outputs, requested) = outputs(call, n, call.arena.frame.has_tangents)?;
    let [positions, normals, tangents] = outputs;
    let place = call.arena.argument.start;
    let job = call.arena.at::<sinew_shapes_job>(place);
    // SAFETY: the place is aligned and large enough, and the structure has no padding.
    unsafe {
        job.write(sinew_shapes_job {
            skin,
            weights,
            weights_len,
            start,
            end,
            positions,
            normals,
            tangents,
        });
    }
    // Other bytes would be pointers to memory that the caller does not own.
    let job = call.input_fixed(place, Argument::Job)?;
    call.shared = true;
    let error = call.ready(|arena| {
        let mut floats = vec![f32::from_ne_bytes([BLANK; 4]); FLOATS * n];
        arena.frame.shape(arena.file_bytes(), start..end, requested, &mut floats);
        bytes(floats)
    });
    // SAFETY: as above.
    Ok(unsafe { sinew_shapes_run(job, error) })
}

pub(super) fn bounds(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    call.fault_if(call.arena.frame.vertex_len == 0, Status::NoVertices, Argument::Skin);
    let (skin, p) = (call.skin()?, call.arena.frame.skin_palette.len());
    let (palette, palette_len) =
        call.input(call.arena.skin_palette.clone(), p, Argument::Palette)?;
    let (weights, weights_len) = weights(call)?;
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(|arena| {
        let bounds = arena.frame.shaped_bounds(arena.file_bytes());
        bytes(bounds.into_iter().flat_map(|bounds| [bounds.min, bounds.max]).flatten())
    });
    // SAFETY: as above.
    Ok(unsafe { sinew_shapes_bounds(skin, palette, palette_len, weights, weights_len, out, error) })
}
