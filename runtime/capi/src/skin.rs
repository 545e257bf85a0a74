//! A skin, and what the file says of it.

use crate::argument::sinew_argument;
use crate::border::{self, Array, Loaded};
use crate::error::{SINEW_NO_PART, sinew_error};
use crate::model::sinew_model;
use crate::part::{self, Opened, Wanted};
use crate::status::sinew_status;
use core::ffi::{c_char, c_void};
use core::mem::{align_of, size_of};
use sinew_runtime::Skin;
use sinew_runtime::skin::SkinLayout;

/// Elements of a `uintptr_t` array that holds a skin on every target:
/// `uintptr_t memory[SINEW_SKIN_WORDS]`.
pub const SINEW_SKIN_WORDS: usize = 48;

/// A mesh of V vertices that follows an envelope's palette, or stays at rest if it follows none. It
/// points to its model: where that has been loaded again with another file, or is loaded no more,
/// every call refuses the skin.
pub struct sinew_skin(Loaded<Opened<SkinLayout>>);

part::part! {
    sinew_skin: SkinLayout to Skin, of Model::skins,
    tag b"SnwS", argument Skin, within SINEW_SKIN_WORDS
}

/// What a skin is made of: every length that its calls need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_skin_info {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    pub name: *const c_char,
    /// Bytes of the name.
    pub name_len: usize,
    /// Its number among the file's parts.
    pub part: u32,
    /// That of the envelope whose palette it follows, or `SINEW_NO_PART`.
    pub envelope_part: u32,
    /// V, vertices.
    pub vertex_len: usize,
    /// K, influences of each vertex.
    pub influence_len: usize,
    /// Transforms of the palette that it takes; 0 without an envelope.
    pub palette_len: usize,
    /// Named ranges of vertices.
    pub range_len: usize,
    /// S, shapes.
    pub shape_len: usize,
    /// 1 with tangents, else 0.
    pub has_tangents: u32,
    /// 1 with tangent coefficients, by which jobs then turn normals and tangents; 0 where they go by cofactors,
    /// which are wrong where transforms part.
    pub has_coefficients: u32,
}

/// A named range of vertices: one of the meshes that the skin was made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_range {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    pub name: *const c_char,
    /// Bytes of the name.
    pub name_len: usize,
    /// First vertex.
    pub start: usize,
    /// One more than the last vertex.
    pub end: usize,
}

/// Returns the bytes of memory that a skin needs: at most those of `SINEW_SKIN_WORDS` words.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_skin_bytes() -> usize {
    size_of::<sinew_skin>()
}

/// Opens a skin of a model.
///
/// - `name`, `name_len`: its name, without a zero at its end; null and 0 for any.
/// - `index`: which of those; 0 for the first.
/// - `memory`, `memory_bytes`: for the skin; at least `sinew_skin_bytes()`, aligned as a `uintptr_t`.
/// - `out_skin`: receives the handle, which is `memory`.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`, `NOT_LOADED`, `NOT_FOUND`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skin_open(
    model: *const sinew_model,
    name: *const c_char,
    name_len: usize,
    index: usize,
    memory: *mut c_void,
    memory_bytes: usize,
    out_skin: *mut *const sinew_skin,
    out_error: *mut sinew_error,
) -> sinew_status {
    let wanted = Wanted { name, name_len, index };
    // SAFETY: the caller's promise is passed on.
    let body = || unsafe { part::open(model, &wanted, memory, memory_bytes, out_skin) };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Says what a skin is made of.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skin_describe(
    skin: *const sinew_skin,
    out_info: *mut sinew_skin_info,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (skin, reads) = unsafe { part::view(skin) }?;
        let out = Array::one(out_info, sinew_argument::Result)?;
        border::apart(&[out.span()], &reads)?;
        let info = sinew_skin_info {
            name: skin.name().as_ptr().cast(),
            name_len: skin.name().len(),
            part: skin.part() as u32,
            envelope_part: skin.envelope_part().map_or(SINEW_NO_PART, |part| part as u32),
            vertex_len: skin.vertex_len(),
            influence_len: skin.influence_len(),
            palette_len: skin.palette_len(),
            range_len: skin.counts().range_len as usize,
            shape_len: skin.shape_len(),
            has_tangents: u32::from(skin.has_tangents()),
            has_coefficients: u32::from(skin.has_coefficients()),
        };
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(info) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
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
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (skin, reads) = unsafe { part::view(skin) }?;
        let out = Array::one(out_range, sinew_argument::Result)?;
        border::apart(&[out.span()], &reads)?;
        let (name, vertices) = skin.ranges().nth(range).ok_or(
            sinew_error::new(sinew_status::OutOfRange, sinew_argument::Range)
                .values((skin.counts().range_len as usize).saturating_sub(1), range),
        )?;
        let found = sinew_range {
            name: name.as_ptr().cast(),
            name_len: name.len(),
            start: vertices.start,
            end: vertices.end,
        };
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(found) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}
