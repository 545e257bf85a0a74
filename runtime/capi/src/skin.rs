//! Skins: opens and describes a skin, and copies its mesh for an engine's buffers.

use crate::argument::sinew_argument;
use crate::border::{self, Array, Loaded};
use crate::error::{SINEW_NO_PART, sinew_error, sinew_status};
use crate::part::{self, Opened};
use core::ffi::c_char;
use core::ops::Range;
use sinew_runtime::Skin;
use sinew_runtime::skin::CacheLine;

/// A mesh of V vertices that follows an envelope's palette. A skin without an envelope stays at rest.
///
/// The skin points to its model. Every call refuses the skin once the model was cleared or has loaded
/// another file.
pub struct sinew_skin(Loaded<Opened>);

part::part! { sinew_skin: Skin, tag b"SnwS", argument Skin }

/// Counts of a skin, and the lengths of all arrays that its calls take.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_skin_info {
    /// Name in UTF-8, in the file's bytes, without a terminating zero.
    pub name: *const c_char,
    /// Length of the name in bytes.
    pub name_len: usize,
    /// Index among the file's parts.
    pub part: u32,
    /// Index of the part whose palette the skin follows, or `SINEW_NO_PART`.
    pub envelope_part: u32,
    /// V, the number of vertices.
    pub vertex_len: usize,
    /// K, the number of influences of each vertex.
    pub influence_len: usize,
    /// Number of transforms of the palette; 0 without an envelope.
    pub palette_len: usize,
    /// Number of named ranges of vertices.
    pub range_len: usize,
    /// S, the number of shapes.
    pub shape_len: usize,
    /// Floats of scratch for `sinew_skin_job`; 0 on firmware.
    pub scratch_len: usize,
    /// 1 if the skin has tangents, otherwise 0.
    pub has_tangents: u32,
    /// 1 if the skin has tangent coefficients, which jobs use for normals and tangents. If 0, jobs use
    /// cofactors, which are wrong where neighbouring transforms differ.
    pub has_coefficients: u32,
    /// Measured errors of the normals over the training poses: RMS of the angle in radians, weighted by the
    /// area at rest. In this order: of the model, of its palette with cofactors, and of linear blend skinning
    /// with cofactors. Negative if the file has none.
    pub normal_errors: [f32; 3],
}

/// An attribute that `sinew_skin_attribute` copies, and its floats per vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum sinew_attribute {
    /// Rest position: 3 floats, in the model's unit.
    Position = 1,
    /// Rest normal: 3 floats.
    Normal = 2,
    /// Rest tangent: 4 floats. The last float is the handedness.
    Tangent = 3,
    /// Tangent coefficients, for shaders that compute normals: 2 (K - 1) floats. They are g and h of each
    /// influence except the first, per unit of length. The first influence has minus the sums of the others.
    TangentCoefficients = 4,
}

impl sinew_attribute {
    /// Returns the attribute with a number, which may be any number of the caller.
    fn from_number(number: u32) -> Result<Self, sinew_error> {
        let known = [Self::Position, Self::Normal, Self::Tangent, Self::TangentCoefficients];
        let unknown = sinew_error::new(sinew_status::OutOfRange, sinew_argument::Attribute)
            .values(Self::TangentCoefficients as usize, number as usize);
        known.into_iter().find(|known| *known as u32 == number).ok_or(unknown)
    }
}

/// A named range of vertices: one of the meshes that the skin was made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_range {
    /// Name in UTF-8, in the file's bytes, without a terminating zero.
    pub name: *const c_char,
    /// Length of the name in bytes.
    pub name_len: usize,
    /// First vertex.
    pub start: usize,
    /// One more than the last vertex.
    pub end: usize,
}

/// Returns the floats of scratch of a job, from any address.
pub(crate) const fn scratch_len(skin: &Skin<'_>) -> usize {
    let line = size_of::<CacheLine>() / size_of::<f32>();
    match skin.scratch_len() {
        0 => 0,
        len => line * len + line - 1,
    }
}

/// Describes a skin.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skin_describe(
    skin: *const sinew_skin,
    out_info: *mut sinew_skin_info,
    out_error: *mut sinew_error,
) -> sinew_status {
    let answer = |skin: &Skin<'_>| {
        Ok(sinew_skin_info {
            name: skin.name().as_ptr().cast(),
            name_len: skin.name().len(),
            part: skin.part() as u32,
            envelope_part: skin.envelope_part().map_or(SINEW_NO_PART, |part| part as u32),
            vertex_len: skin.vertex_len(),
            influence_len: skin.influence_len(),
            palette_len: skin.palette_len(),
            range_len: skin.counts().range_len as usize,
            shape_len: skin.shape_len(),
            scratch_len: scratch_len(skin),
            has_tangents: u32::from(skin.has_tangents()),
            has_coefficients: u32::from(skin.has_coefficients()),
            normal_errors: skin.normal_errors().map_or([-1.0; 3], |errors| errors.figures()),
        })
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { part::describe(skin, out_info, out_error, answer) }
}

/// Describes a named range of vertices.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`, `OUT_OF_RANGE`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skin_range(
    skin: *const sinew_skin,
    range: usize,
    out_range: *mut sinew_range,
    out_error: *mut sinew_error,
) -> sinew_status {
    let answer = |skin: &Skin<'_>| {
        let len = skin.counts().range_len as usize;
        let outside = sinew_error::out_of_range(sinew_argument::Range, range, len);
        let (name, Range { start, end }) = skin.ranges().nth(range).ok_or(outside)?;
        Ok(sinew_range { name: name.as_ptr().cast(), name_len: name.len(), start, end })
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { part::describe(skin, out_range, out_error, answer) }
}

/// Copies an attribute of the vertices from `start` to before `end`, packed.
///
/// - `attribute`: a `sinew_attribute`, which states the floats per vertex.
/// - `out`, `out_len`: room for the floats of `end - start` vertices.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `NO_ATTRIBUTE`, `OUT_OF_RANGE`, `TOO_SHORT`,
/// `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skin_attribute(
    skin: *const sinew_skin,
    attribute: u32,
    start: usize,
    end: usize,
    out: *mut f32,
    out_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    use sinew_attribute as A;
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (skin, reads) = unsafe { part::view(skin) }?;
        let attribute = A::from_number(attribute)?;
        let (argument, is_there, float_len) = match attribute {
            A::Position => (sinew_argument::Positions, true, 3),
            A::Normal => (sinew_argument::Normals, true, 3),
            A::Tangent => (sinew_argument::Tangents, skin.has_tangents(), 4),
            A::TangentCoefficients => {
                let pair_len = skin.influence_len().saturating_sub(1);
                (sinew_argument::Coefficients, skin.has_coefficients(), 2 * pair_len)
            }
        };
        if !is_there {
            return Err(sinew_error::new(sinew_status::NoAttribute, argument));
        }
        let out = Array::new(out, out_len, argument)?;
        let vertices = start..end;
        check_vertices(&skin, &vertices)?;
        out.check_least(vertices.len().saturating_mul(float_len))?;
        border::check_disjoint(&[out.span()], &reads)?;
        // SAFETY: lent by the caller; the call reads no part of it.
        let out = unsafe { out.write() };
        match attribute {
            A::Position => fill(out, vertices.filter_map(|vertex| skin.rest_position(vertex))),
            A::Normal => fill(out, vertices.filter_map(|vertex| skin.rest_normal(vertex))),
            A::Tangent => fill(out, vertices.filter_map(|vertex| skin.rest_tangent(vertex))),
            A::TangentCoefficients => {
                fill(out, vertices.flat_map(|vertex| skin.tangent_coefficients(vertex)));
            }
        }
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Copies the K influences of each vertex from `start` to before `end`. A skinning shader needs only these
/// and the palette. Unused influences have weight 0; the weights of a vertex sum to 1.
///
/// - `out_indices`, `indices_len`: room for `K * (end - start)` indices into the palette.
/// - `out_weights`, `weights_len`: room for `K * (end - start)` weights.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OUT_OF_RANGE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
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
        border::check_disjoint(&[indices.span(), weights.span()], &reads)?;
        // SAFETY: lent by the caller; the arrays overlap neither each other nor memory that the call reads.
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

/// Computes the hash of a skin's rest positions, which identifies the mesh and its vertex order.
///
/// - `out_hash`: receives the hash, as `sinew_mesh_hash` computes it.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skin_mesh_hash(
    skin: *const sinew_skin,
    out_hash: *mut u32,
    out_error: *mut sinew_error,
) -> sinew_status {
    // SAFETY: the caller's promise is passed on.
    unsafe { part::describe(skin, out_hash, out_error, |skin| Ok(skin.mesh_hash())) }
}

/// Computes the hash of a mesh's rest positions, to compare with `sinew_skin_mesh_hash`.
///
/// - `positions`, `vertex_len`: 3 floats per vertex, packed, in the file's order.
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
        border::check_disjoint(&[out.span()], &[positions.span()])?;
        // SAFETY: lent by the caller; written memory does not overlap it.
        let hash = sinew_runtime::mesh_hash_of(unsafe { positions.read() });
        // SAFETY: one element, which the caller allows to be written.
        unsafe { out.store(hash) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Copies rows of floats to the start of an array.
fn fill<const N: usize>(out: &mut [f32], rows: impl Iterator<Item = [f32; N]>) {
    for (out, float) in out.iter_mut().zip(rows.flatten()) {
        *out = float;
    }
}

/// Checks that a range of vertices is in the mesh.
fn check_vertices(skin: &Skin<'_>, vertices: &Range<usize>) -> Result<(), sinew_error> {
    let (Range { start, end }, vertex_len) = (vertices, skin.vertex_len());
    if start <= end && *end <= vertex_len {
        return Ok(());
    }
    let error = sinew_error::new(sinew_status::OutOfRange, sinew_argument::Vertices);
    Err(error.at(*start).values(vertex_len, *end))
}
