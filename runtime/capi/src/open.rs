//! Opens the parts of a model.

use crate::argument::sinew_argument;
use crate::border::{self, Loaded};
use crate::envelope::sinew_envelope;
use crate::error::{sinew_error, sinew_status};
use crate::filter::sinew_filter;
use crate::kernel::sinew_kernel;
use crate::model::sinew_model;
use crate::part::{Opened, Opening};
use crate::prior::sinew_prior;
use crate::skin::sinew_skin;
use crate::views::sinew_views;
use core::ffi::{c_char, c_void};

/// A kind of part that `sinew_part_open` opens, with its number in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum sinew_part_kind {
    /// A `sinew_envelope`.
    Envelope = 1,
    /// A `sinew_skin`.
    Skin = 2,
    /// A `sinew_kernel`.
    Kernel = 3,
    /// A `sinew_prior`.
    Prior = 4,
    /// A `sinew_views`.
    Views = 5,
    /// A `sinew_filter`.
    Filter = 6,
}

/// Returns the size of a part of any kind in bytes: at most `SINEW_PART_WORDS` words.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_part_bytes() -> usize {
    size_of::<Loaded<Opened>>()
}

/// Opens a part of a model: an envelope, a skin, a kernel, a prior, views or a filter.
///
/// - `kind`: a `sinew_part_kind`.
/// - `name`, `name_len`: the part's name in UTF-8, without a terminating zero; null and 0 match every name.
/// - `index`: position among the parts of this kind with this name; 0 is the first.
/// - `memory`, `memory_bytes`: memory for the part: at least `sinew_part_bytes()` bytes, aligned like a
///   `uintptr_t`. After success its address is the handle, for example a `const sinew_skin *`.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`, `NOT_LOADED`, `OUT_OF_RANGE`,
/// `NOT_FOUND`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_part_open(
    model: *const sinew_model,
    kind: u32,
    name: *const c_char,
    name_len: usize,
    index: usize,
    memory: *mut c_void,
    memory_bytes: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    use sinew_part_kind as K;
    let opening = Opening { model, name, name_len, index, memory, memory_bytes };
    let body = || {
        // SAFETY: the caller's promise is passed on.
        unsafe {
            match kind {
                kind if kind == K::Envelope as u32 => opening.open::<sinew_envelope>(),
                kind if kind == K::Skin as u32 => opening.open::<sinew_skin>(),
                kind if kind == K::Kernel as u32 => opening.open::<sinew_kernel>(),
                kind if kind == K::Prior as u32 => opening.open::<sinew_prior>(),
                kind if kind == K::Views as u32 => opening.open::<sinew_views>(),
                kind if kind == K::Filter as u32 => opening.open::<sinew_filter>(),
                _ => Err(sinew_error::new(sinew_status::OutOfRange, sinew_argument::Kind)
                    .values(K::Filter as usize, kind as usize)),
            }
        }
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}
