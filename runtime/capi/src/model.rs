//! Models: loads a file and describes its contents.

use crate::argument::sinew_argument;
use crate::border::{self, Array, Loaded, Object, Span};
use crate::error::{sinew_error, sinew_status};
use core::ffi::c_void;
use core::mem::{align_of, offset_of, size_of};
use sinew_runtime::format::{Axis, Handedness};
use sinew_runtime::{Envelope, KernelMap, Limits, Model, Skin};

/// Length of a `uintptr_t` array that can hold a model on every target:
/// `uintptr_t memory[SINEW_MODEL_WORDS]`.
pub const SINEW_MODEL_WORDS: usize = 192;

/// A loaded file, read in place: the file's bytes stay in place and unchanged while the model is in use.
///
/// The model's memory may be loaded again while no call uses it, with the same file or another. Filling the
/// memory with zeros clears the model; nothing has to be freed. Parts point to the model, so the model
/// stays in place and outlives its parts.
pub struct sinew_model(Loaded<Model<&'static [u8]>>);

impl Object for sinew_model {
    type Value = Model<&'static [u8]>;
    const TAG: u32 = u32::from_le_bytes(*b"SnwM");
    const ARGUMENT: sinew_argument = sinew_argument::Model;

    fn loaded(&self) -> &Loaded<Self::Value> {
        &self.0
    }
}

const _: () = {
    assert!(size_of::<sinew_model>() <= SINEW_MODEL_WORDS * size_of::<usize>());
    assert!(align_of::<sinew_model>() <= align_of::<usize>());
};

/// Maximum counts of a file. The work of loading and evaluating depends only on these counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_limits {
    /// Bytes of the file.
    pub file_bytes: u32,
    /// Parts of the file.
    pub parts: u16,
    /// Sections of the file.
    pub sections: u16,
    /// Vertices of a skin.
    pub vertices: u32,
    /// Joints of an envelope.
    pub joints: u32,
    /// Proxies of an envelope.
    pub proxies: u32,
    /// Influences of a vertex.
    pub influences: u32,
    /// Shapes of a skin.
    pub shapes: u32,
    /// Curves of an envelope.
    pub curves: u32,
}

// Calls read and write the caller's limits as the runtime's structure, which has these fields in this order.
const _: () = {
    assert!(size_of::<sinew_limits>() == size_of::<Limits>());
    assert!(offset_of!(sinew_limits, file_bytes) == offset_of!(Limits, file_bytes));
    assert!(offset_of!(sinew_limits, parts) == offset_of!(Limits, parts));
    assert!(offset_of!(sinew_limits, sections) == offset_of!(Limits, sections));
    assert!(offset_of!(sinew_limits, vertices) == offset_of!(Limits, vertices));
    assert!(offset_of!(sinew_limits, joints) == offset_of!(Limits, joints));
    assert!(offset_of!(sinew_limits, proxies) == offset_of!(Limits, proxies));
    assert!(offset_of!(sinew_limits, influences) == offset_of!(Limits, influences));
    assert!(offset_of!(sinew_limits, shapes) == offset_of!(Limits, shapes));
    assert!(offset_of!(sinew_limits, curves) == offset_of!(Limits, curves));
};

/// A signed axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum sinew_axis {
    /// The file does not record the axis.
    Unknown = 0,
    /// Positive x.
    X = 1,
    /// Negative x.
    MinusX = 2,
    /// Positive y.
    Y = 3,
    /// Negative y.
    MinusY = 4,
    /// Positive z.
    Z = 5,
    /// Negative z.
    MinusZ = 6,
}

/// Direction of the third axis, relative to the first two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum sinew_handedness {
    /// x cross y is z.
    Right = 1,
    /// x cross y is -z.
    Left = 2,
}

/// Contents of a file, and the space of its numbers. Rest meshes, poses and results all use this space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_model_info {
    /// Number of parts, including kinds that the library does not know.
    pub part_len: usize,
    /// Number of envelopes.
    pub envelope_len: usize,
    /// Number of skins.
    pub skin_len: usize,
    /// Number of kernels.
    pub kernel_len: usize,
    /// Axis that points to a character's head.
    pub up: sinew_axis,
    /// Axis along which a character looks.
    pub forward: sinew_axis,
    /// Handedness of the axes.
    pub handedness: sinew_handedness,
    /// Metres per unit of length; 0 if the file does not record the unit.
    pub unit: f32,
}

/// Place of a section in the file's blob.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_section {
    /// Offset from the start of the blob in bytes; a multiple of 16.
    pub offset: u32,
    /// Length in bytes.
    pub bytes: u32,
}

/// Returns the size of a model in bytes: at most `SINEW_MODEL_WORDS` words.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_model_bytes() -> usize {
    size_of::<sinew_model>()
}

/// Writes the default limits of `sinew_model_load`, which are generous for any character.
///
/// Returns `NULL`, `MISALIGNED`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_limits_default(
    out_limits: *mut sinew_limits,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let out = Array::one(out_limits.cast::<Limits>(), sinew_argument::Result)?;
        // SAFETY: one element, which the caller allows to be written.
        unsafe { out.store(Limits::DEFAULT) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Loads a model in place and validates the whole file, in time bounded by the file's length. After success
/// no evaluation fails because of the file.
///
/// If the memory held another file before, calls refuse the parts of that file from now on. A failed load
/// changes nothing.
///
/// - `memory`, `memory_bytes`: memory for the model: at least `sinew_model_bytes()` bytes, aligned like a
///   `uintptr_t`.
/// - `file`, `file_bytes`: the file, at any address; the bytes are not copied.
/// - `limits`: null for the default limits.
/// - `out_model`: receives the handle, which equals `memory`.
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
        let file = Array::new(file, file_bytes, sinew_argument::File)?;
        let limits = Array::optional(limits.cast::<Limits>(), sinew_argument::Limits)?;
        let out = Array::one(out_model, sinew_argument::Result)?;
        border::check_disjoint(&[place.span(), out.span()], &[file.span(), limits.span()])?;
        // SAFETY: the caller keeps the file for as long as the model is in use.
        let file = unsafe { file.read() };
        // SAFETY: lent by the caller, and copied immediately.
        let limits = unsafe { limits.read() }.first().copied().unwrap_or_default();
        let model = Model::from_bytes_with(file, &limits)?;
        // SAFETY: the memory is large enough, aligned, lent by the caller, and does not overlap the file.
        unsafe { place.store(sinew_model(Loaded::new::<sinew_model>(model))) };
        // SAFETY: one element, which the caller allows to be written.
        unsafe { out.store(memory.cast_const().cast()) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Describes the contents of a file and its space.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_model_describe(
    model: *const sinew_model,
    out_info: *mut sinew_model_info,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (model, reads) = unsafe { loaded(model) }?;
        let out = Array::one(out_info, sinew_argument::Result)?;
        border::check_disjoint(&[out.span()], &reads)?;
        let space = model.space();
        let info = sinew_model_info {
            part_len: model.parts().len(),
            envelope_len: model.all::<Envelope>().count(),
            skin_len: model.all::<Skin>().count(),
            kernel_len: model.all::<KernelMap>().count(),
            up: axis(space.up),
            forward: axis(space.forward),
            handedness: match space.handedness {
                Handedness::Right => sinew_handedness::Right,
                Handedness::Left => sinew_handedness::Left,
            },
            unit: space.unit.unwrap_or(0.0),
        };
        // SAFETY: one element, which the caller allows to be written.
        unsafe { out.store(info) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Returns the file's blob, which a GPU takes as one buffer. `sinew_model_section` gives the offset of each
/// section in the blob.
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
        let (model, reads) = unsafe { loaded(model) }?;
        let out = Array::one(out_blob, sinew_argument::Result)?;
        let out_len = Array::one(out_bytes, sinew_argument::SecondResult)?;
        border::check_disjoint(&[out.span(), out_len.span()], &reads)?;
        let blob = model.blob();
        // SAFETY: one element each, which the caller allows to be written; the object is not read again.
        unsafe { (out.store(blob.as_ptr()), out_len.store(blob.len())) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Finds a section of a part.
///
/// - `part`: `sinew_envelope_info.part`, `sinew_skin_info.part` or `sinew_kernel_info.part`.
/// - `kind`: the section's number in FORMAT.md. The library need not know the kind.
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
        let (model, reads) = unsafe { loaded(model) }?;
        let out = Array::one(out_section, sinew_argument::Result)?;
        border::check_disjoint(&[out.span()], &reads)?;
        let found = model.sections().find(|section| {
            u32::from(section.row.part) == part && u32::from(section.row.kind) == kind
        });
        let not_found = sinew_error::new(sinew_status::NotFound, sinew_argument::Section);
        let row = found.ok_or(sinew_error { part, section: kind, ..not_found })?.row;
        // SAFETY: one element, which the caller allows to be written.
        unsafe { out.store(sinew_section { offset: row.offset, bytes: row.bytes }) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Returns a loaded model and the memory that a call with the model reads: the object and the file.
///
/// # Safety
/// `at` is null, or points to memory as large as a model, which stays unchanged for `'a`.
pub(crate) unsafe fn loaded<'a>(
    at: *const sinew_model,
) -> Result<(&'a Model<&'static [u8]>, [Span; 2]), sinew_error> {
    // SAFETY: the caller's promise is passed on.
    let (model, handle) = unsafe { border::object(at) }?;
    Ok((model, [handle, Span::of(model.as_bytes(), sinew_argument::File)]))
}

fn axis(axis: Option<Axis>) -> sinew_axis {
    match axis {
        None => sinew_axis::Unknown,
        Some(Axis::X) => sinew_axis::X,
        Some(Axis::MinusX) => sinew_axis::MinusX,
        Some(Axis::Y) => sinew_axis::Y,
        Some(Axis::MinusY) => sinew_axis::MinusY,
        Some(Axis::Z) => sinew_axis::Z,
        Some(Axis::MinusZ) => sinew_axis::MinusZ,
    }
}
