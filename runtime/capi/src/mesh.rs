//! The mesh: rest pose and influences, copied for an engine's own buffers.

use crate::border::{self, Array};
use crate::envelope::check_vertices;
use crate::{sinew_envelope, sinew_error, sinew_status, sinew_subject};
use core::ops::Range;
use sinew_runtime::Envelope;

/// Copies the rest positions of the vertices from `start` to before `end`: 3 floats each, packed.
///
/// - `out_positions`, `out_len`: room for `3 * (end - start)` floats.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `OUT_OF_RANGE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_rest_positions(
    envelope: *const sinew_envelope,
    start: usize,
    end: usize,
    out_positions: *mut f32,
    out_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let out = Array::new(out_positions, out_len, sinew_subject::Positions);
        // SAFETY: the caller's promise is passed on.
        unsafe { copy(envelope, start..end, out, Envelope::rest_position) }
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Copies the rest normals of the vertices from `start` to before `end`: 3 floats each, packed.
///
/// - `out_normals`, `out_len`: room for `3 * (end - start)` floats.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `OUT_OF_RANGE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_rest_normals(
    envelope: *const sinew_envelope,
    start: usize,
    end: usize,
    out_normals: *mut f32,
    out_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let out = Array::new(out_normals, out_len, sinew_subject::Normals);
        // SAFETY: the caller's promise is passed on.
        unsafe { copy(envelope, start..end, out, Envelope::rest_normal) }
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Copies the rest tangents of the vertices from `start` to before `end`: 4 floats each, packed,
/// the last the handedness.
///
/// - `out_tangents`, `out_len`: room for `4 * (end - start)` floats.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `NO_TANGENTS`, `OUT_OF_RANGE`, `TOO_SHORT`,
/// `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_rest_tangents(
    envelope: *const sinew_envelope,
    start: usize,
    end: usize,
    out_tangents: *mut f32,
    out_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        if !unsafe { border::object(envelope) }?.0.has_tangents() {
            return Err(sinew_error::new(sinew_status::NoTangents, sinew_subject::Tangents));
        }
        let out = Array::new(out_tangents, out_len, sinew_subject::Tangents);
        // SAFETY: the caller's promise is passed on.
        unsafe { copy(envelope, start..end, out, Envelope::rest_tangent) }
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Copies the K influences of each vertex from `start` to before `end`: with a palette, all that a
/// skinning shader needs. Unused ones weigh 0; those of a vertex sum to 1.
///
/// - `out_indices`, `indices_len`: room for `K * (end - start)` indices into the palette.
/// - `out_weights`, `weights_len`: room for as many weights.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `OUT_OF_RANGE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_envelope_influences(
    envelope: *const sinew_envelope,
    start: usize,
    end: usize,
    out_indices: *mut u16,
    indices_len: usize,
    out_weights: *mut f32,
    weights_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (envelope, reads) = unsafe { border::object(envelope) }?;
        let indices = Array::new(out_indices, indices_len, sinew_subject::Indices)?;
        let weights = Array::new(out_weights, weights_len, sinew_subject::Weights)?;
        let vertices = start..end;
        check_vertices(envelope, &vertices)?;
        let least = vertices.len().saturating_mul(envelope.influence_len());
        indices.check_least(least)?;
        weights.check_least(least)?;
        border::apart(&[indices.span(), weights.span()], &reads)?;
        // SAFETY: apart from each other and from all that the call reads; lent by the caller.
        let (indices, weights) = unsafe { (indices.write(), weights.write()) };
        let influences = vertices.flat_map(|vertex| envelope.influences(vertex));
        for ((out_index, out_weight), (index, weight)) in
            indices.iter_mut().zip(weights).zip(influences)
        {
            *out_index = index as u16;
            *out_weight = weight;
        }
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Copies N floats of each vertex.
///
/// # Safety
/// The handle is null or points to memory as large as an envelope; the array is the caller's to
/// write.
unsafe fn copy<const N: usize>(
    envelope: *const sinew_envelope,
    vertices: Range<usize>,
    out: Result<Array<f32>, sinew_error>,
    read: impl Fn(&Envelope<'static>, usize) -> Option<[f32; N]>,
) -> Result<(), sinew_error> {
    // SAFETY: the caller's promise is passed on.
    let (envelope, reads) = unsafe { border::object(envelope) }?;
    let out = out?;
    check_vertices(envelope, &vertices)?;
    out.check_least(vertices.len().saturating_mul(N))?;
    border::apart(&[out.span()], &reads)?;
    // SAFETY: apart from all that the call reads; lent by the caller.
    let (out, _) = unsafe { out.write() }.as_chunks_mut::<N>();
    for (out, value) in out.iter_mut().zip(vertices.map_while(|vertex| read(envelope, vertex))) {
        *out = value;
    }
    Ok(())
}
