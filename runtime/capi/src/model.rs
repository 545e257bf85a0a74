//! A loaded file.

use crate::border::{self, Array, Loaded, Object};
use crate::{sinew_error, sinew_status, sinew_subject};
use core::ffi::c_void;
use core::mem::{align_of, size_of};
use sinew_runtime::format::SectionKind;
use sinew_runtime::{Limits, Model};

/// Elements of a `uintptr_t` array that holds a model on every target:
/// `uintptr_t memory[SINEW_MODEL_WORDS]`.
pub const SINEW_MODEL_WORDS: usize = 12;

/// A loaded file: a view of its bytes, which must stay where they are and as they are for as long
/// as the model or an envelope of it is used. It never changes and may be used on any number of
/// threads at once. It may be moved with `memcpy`, and needs no destruction.
pub struct sinew_model(Loaded<Model<'static>>);

impl Object for sinew_model {
    type Value = Model<'static>;
    const TAG: u32 = u32::from_le_bytes(*b"SnwM");
    const SUBJECT: sinew_subject = sinew_subject::Model;

    fn loaded(&self) -> &Loaded<Self::Value> {
        &self.0
    }
}

const _: () = {
    assert!(size_of::<sinew_model>() <= SINEW_MODEL_WORDS * size_of::<usize>());
    assert!(align_of::<sinew_model>() <= align_of::<usize>());
};

/// The most of everything that a file may hold. All work, of loading and of evaluating, grows with
/// these counts and with nothing else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_limits {
    /// Bytes of the file.
    pub file_bytes: u32,
    /// Vertices of a part.
    pub vertices: u32,
    /// Joints of a part.
    pub joints: u32,
    /// Proxies of a part.
    pub proxies: u32,
    /// Influences of a vertex.
    pub influences: u32,
}

/// A section of the file, known to the library or not, by its number in FORMAT.md.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_section {
    /// Where it starts, in bytes from the blob's start; a multiple of the file's alignment.
    pub offset: u32,
    /// Its length in bytes.
    pub bytes: u32,
}

/// Returns the bytes of memory that a model needs: at most those of `SINEW_MODEL_WORDS` words.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_model_bytes() -> usize {
    size_of::<sinew_model>()
}

/// Returns the alignment of the memory for models and envelopes: that of `uintptr_t`, or less.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_object_alignment() -> usize {
    let (model, envelope) = (align_of::<sinew_model>(), align_of::<crate::sinew_envelope>());
    if model > envelope { model } else { envelope }
}

/// Writes the limits that `sinew_model_load` has without others: generous for any character.
///
/// Returns `NULL`, `MISALIGNED`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_limits_default(
    out_limits: *mut sinew_limits,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let out = Array::one(out_limits, sinew_subject::Result)?;
        let Limits { file_bytes, vertices, joints, proxies, influences } = Limits::DEFAULT;
        let limits = sinew_limits { file_bytes, vertices, joints, proxies, influences };
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(limits) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Loads a model in place and checks all of it, in time bounded by the file's length. After that
/// no evaluation fails for the file's sake.
///
/// - `memory`, `memory_bytes`: for the model; at least `sinew_model_bytes()`, aligned as a
///   `uintptr_t`.
/// - `file`, `file_bytes`: the file, at any address; not copied.
/// - `limits`: null for the default ones.
/// - `out_model`: receives the handle, which is `memory`.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`, and every status from 100 on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_model_load(
    memory: *mut c_void,
    memory_bytes: usize,
    file: *const u8,
    file_bytes: usize,
    limits: *const sinew_limits,
    out_model: *mut *const sinew_model,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let place = border::place::<sinew_model>(memory, memory_bytes)?;
        let file = Array::new(file, file_bytes, sinew_subject::File)?;
        let limits = Array::optional(limits, sinew_subject::Limits)?;
        let out = Array::one(out_model, sinew_subject::Result)?;
        let span = file.span();
        border::apart(&[place.span(), out.span()], &[span, limits.span()])?;
        // SAFETY: the caller keeps the file for as long as anything made of it is used.
        let file = unsafe { file.read::<'static>() };
        // SAFETY: lent by the caller; the values are copied at once.
        let limits = unsafe { limits.read() }.first().map_or(Limits::DEFAULT, Limits::from);
        let model = Model::from_bytes_with(file, &limits)?;
        // SAFETY: memory large enough, aligned, apart from the file, and lent by the caller.
        unsafe { place.store(sinew_model(Loaded::new::<sinew_model>(model, span))) };
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(memory.cast_const().cast()) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Returns the blob, which holds every section at the offset that `sinew_model_section` gives:
/// what a GPU is given, as one buffer.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_model_blob(
    model: *const sinew_model,
    out_blob: *mut *const u8,
    out_bytes: *mut usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (model, reads) = unsafe { border::object(model) }?;
        let out = Array::one(out_blob, sinew_subject::Result)?;
        let out_len = Array::one(out_bytes, sinew_subject::SecondResult)?;
        border::apart(&[out.span(), out_len.span()], &reads)?;
        let blob = model.blob();
        // SAFETY: one element each, which the caller lets be written; the object is not read again.
        unsafe { (out.store(blob.as_ptr()), out_len.store(blob.len())) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Finds a section of a part.
///
/// - `part`: `sinew_envelope_info.part`.
/// - `kind`: its number in FORMAT.md; `SINEW_SUBJECT_SECTION_C1 - SINEW_SUBJECT_CERTIFICATE`, say.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `OVERLAP`, `NOT_FOUND`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_model_section(
    model: *const sinew_model,
    part: u32,
    kind: u32,
    out_section: *mut sinew_section,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (model, reads) = unsafe { border::object(model) }?;
        let out = Array::one(out_section, sinew_subject::Result)?;
        border::apart(&[out.span()], &reads)?;
        let found = model.sections().find(|section| {
            u32::from(section.row.part) == part && u32::from(section.row.kind) == kind
        });
        let row = found.map(|section| section.row).ok_or_else(|| {
            let known = u16::try_from(kind).ok().and_then(SectionKind::from_number);
            sinew_error::new(
                sinew_status::NotFound,
                known.map_or(sinew_subject::None, sinew_subject::from),
            )
            .found(u64::from(kind))
        })?;
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(sinew_section { offset: row.offset, bytes: row.bytes }) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

impl From<&sinew_limits> for Limits {
    fn from(limits: &sinew_limits) -> Self {
        let sinew_limits { file_bytes, vertices, joints, proxies, influences } = *limits;
        Self { file_bytes, vertices, joints, proxies, influences }
    }
}
