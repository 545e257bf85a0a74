//! The mesh of a skin: rest pose and influences, copied for an engine's own buffers.

use crate::argument::sinew_argument;
use crate::border::{self, Array};
use crate::error::sinew_error;
use crate::part;
use crate::skin::sinew_skin;
use crate::status::sinew_status;
use core::ops::Range;
use sinew_runtime::Skin;

/// Copies the rest positions of the vertices from `start` to before `end`: 3 floats each, packed.
///
/// - `out_positions`, `out_len`: room for `3 * (end - start)` floats.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OUT_OF_RANGE`, `TOO_SHORT`, `TOO_LONG`,
/// `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skin_rest_positions(
    skin: *const sinew_skin,
    start: usize,
    end: usize,
    out_positions: *mut f32,
    out_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let out = Array::new(out_positions, out_len, sinew_argument::Positions);
        // SAFETY: the caller's promise is passed on.
        unsafe { copy(skin, start..end, out, Skin::rest_position) }
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Copies the rest normals of the vertices from `start` to before `end`: 3 floats each, packed.
///
/// - `out_normals`, `out_len`: room for `3 * (end - start)` floats.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OUT_OF_RANGE`, `TOO_SHORT`, `TOO_LONG`,
/// `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skin_rest_normals(
    skin: *const sinew_skin,
    start: usize,
    end: usize,
    out_normals: *mut f32,
    out_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let out = Array::new(out_normals, out_len, sinew_argument::Normals);
        // SAFETY: the caller's promise is passed on.
        unsafe { copy(skin, start..end, out, Skin::rest_normal) }
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Copies the rest tangents of the vertices from `start` to before `end`: 4 floats each, packed,
/// the last the handedness.
///
/// - `out_tangents`, `out_len`: room for `4 * (end - start)` floats.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `NO_ATTRIBUTE`, `OUT_OF_RANGE`, `TOO_SHORT`,
/// `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skin_rest_tangents(
    skin: *const sinew_skin,
    start: usize,
    end: usize,
    out_tangents: *mut f32,
    out_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        if !unsafe { part::view(skin) }?.0.has_tangents() {
            return Err(sinew_error::new(sinew_status::NoAttribute, sinew_argument::Tangents));
        }
        let out = Array::new(out_tangents, out_len, sinew_argument::Tangents);
        // SAFETY: the caller's promise is passed on.
        unsafe { copy(skin, start..end, out, Skin::rest_tangent) }
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
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OUT_OF_RANGE`, `TOO_SHORT`, `TOO_LONG`,
/// `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skin_influences(
    skin: *const sinew_skin,
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
        let (skin, reads) = unsafe { part::view(skin) }?;
        let indices = Array::new(out_indices, indices_len, sinew_argument::Indices)?;
        let weights = Array::new(out_weights, weights_len, sinew_argument::Weights)?;
        let vertices = start..end;
        check_vertices(&skin, &vertices)?;
        let least = vertices.len().saturating_mul(skin.influence_len());
        indices.check_least(least)?;
        weights.check_least(least)?;
        border::apart(&[indices.span(), weights.span()], &reads)?;
        // SAFETY: apart from each other and from all that the call reads; lent by the caller.
        let (indices, weights) = unsafe { (indices.write(), weights.write()) };
        let influences = vertices.flat_map(|vertex| skin.influences(vertex));
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

/// Computes the hash of a skin's rest positions: which mesh it is, and in which order.
///
/// - `out_hash`: receives what `sinew_mesh_hash` gives of them.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skin_mesh_hash(
    skin: *const sinew_skin,
    out_hash: *mut u32,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (skin, reads) = unsafe { part::view(skin) }?;
        let out = Array::one(out_hash, sinew_argument::Result)?;
        border::apart(&[out.span()], &reads)?;
        let hash = skin.mesh_hash();
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(hash) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Computes the hash of a mesh's rest positions, to compare with `sinew_skin_mesh_hash`.
///
/// - `positions`, `vertex_len`: 3 floats a vertex, packed, in the file's order.
/// - `out_hash`: receives the hash.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_mesh_hash(
    positions: *const f32,
    vertex_len: usize,
    out_hash: *mut u32,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let at = positions.cast::<[f32; 3]>();
        let positions = Array::new(at, vertex_len, sinew_argument::RestPositions)?;
        let out = Array::one(out_hash, sinew_argument::Result)?;
        border::apart(&[out.span()], &[positions.span()])?;
        // SAFETY: lent by the caller, and apart from what is written.
        let hash = sinew_runtime::mesh_hash_of(unsafe { positions.read() });
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(hash) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Copies an attribute of N floats.
///
/// # Safety
/// The handle is null or points to memory as large as a skin; the array is the caller's to write.
unsafe fn copy<'a, const N: usize>(
    skin: *const sinew_skin,
    vertices: Range<usize>,
    out: Result<Array<f32>, sinew_error>,
    attribute: impl Fn(&Skin<'a>, usize) -> Option<[f32; N]>,
) -> Result<(), sinew_error> {
    // SAFETY: the caller's promise is passed on.
    let (skin, reads) = unsafe { part::view(skin) }?;
    let out = out?;
    check_vertices(&skin, &vertices)?;
    out.check_least(vertices.len().saturating_mul(N))?;
    border::apart(&[out.span()], &reads)?;
    // SAFETY: apart from all that the call reads; lent by the caller.
    let (out, _) = unsafe { out.write() }.as_chunks_mut::<N>();
    for (out, vertex) in out.iter_mut().zip(vertices) {
        *out = attribute(&skin, vertex).unwrap_or(*out);
    }
    Ok(())
}

/// Checks that vertices are in the mesh.
fn check_vertices(skin: &Skin<'_>, vertices: &Range<usize>) -> Result<(), sinew_error> {
    let (Range { start, end }, vertex_len) = (vertices, skin.vertex_len());
    if start <= end && *end <= vertex_len {
        return Ok(());
    }
    let error = sinew_error::new(sinew_status::OutOfRange, sinew_argument::Vertices);
    Err(error.at(*start).values(vertex_len, *end))
}
