//! A filter, what the file says of it, and the signals that it makes finer.

use crate::argument::sinew_argument;
use crate::border::{self, Array, Loaded};
use crate::error::{sinew_error, sinew_status};
use crate::model::sinew_model;
use crate::part::{self, Opened, Opening};
use core::ffi::{c_char, c_void};
use core::mem::{align_of, size_of};
use sinew_runtime::Filter;
use sinew_runtime::filter::{FilterLayout, Samples};

/// Elements of a `uintptr_t` array that holds a filter on every target:
/// `uintptr_t memory[SINEW_FILTER_WORDS]`.
pub const SINEW_FILTER_WORDS: usize = 48;

/// Weights that make a signal finer. It points to its model: where that has been loaded again with another file,
/// or is loaded no more, every call refuses the filter.
pub struct sinew_filter(Loaded<Opened<FilterLayout>>);

part::part! {
    sinew_filter: FilterLayout to Filter, of Model::filters,
    tag b"SnwF", argument Filter, within SINEW_FILTER_WORDS
}

/// What a filter is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_filter_info {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    pub name: *const c_char,
    /// Bytes of the name.
    pub name_len: usize,
    /// Its number among the file's parts.
    pub part: u32,
    /// F, fine samples of each coarse one.
    pub factor: usize,
    /// N, coarse samples that each fine one is made of: no signal may be shorter.
    pub tap_len: usize,
    /// From one coarse sample to the next, in the unit of what the signal runs along; 0 if it has none.
    pub step: f32,
    /// RMS error over samples that were left out, in the signal's unit; 0 if it was not measured.
    pub left_out_rms: f32,
    /// The same of linear interpolation.
    pub linear_rms: f32,
}

/// How samples lie: signals one after the other, of samples one after the other, of lanes side by side. An image
/// of H rows of W pixels of C channels is along its columns one signal of H samples of W C lanes, and along its rows H
/// signals of W samples of C lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_samples {
    /// Signals.
    pub signal_len: usize,
    /// Samples of each signal.
    pub sample_len: usize,
    /// Numbers of each sample, each of which goes by itself.
    pub lane_len: usize,
}

/// Returns the bytes of memory that a filter needs: at most those of `SINEW_FILTER_WORDS` words.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_filter_bytes() -> usize {
    size_of::<sinew_filter>()
}

/// Opens a filter of a model.
///
/// - `name`, `name_len`: its name, without a zero at its end; null and 0 for any.
/// - `index`: which of those; 0 for the first.
/// - `memory`, `memory_bytes`: for the filter; at least `sinew_filter_bytes()`, aligned as a `uintptr_t`.
/// - `out_filter`: receives the handle, which is `memory`.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`, `NOT_LOADED`, `NOT_FOUND`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_filter_open(
    model: *const sinew_model,
    name: *const c_char,
    name_len: usize,
    index: usize,
    memory: *mut c_void,
    memory_bytes: usize,
    out_filter: *mut *const sinew_filter,
    out_error: *mut sinew_error,
) -> sinew_status {
    let opening = Opening { model, name, name_len, index, memory, memory_bytes };
    // SAFETY: the caller's promise is passed on.
    unsafe { opening.open(out_filter, out_error) }
}

/// Says what a filter is made of.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_filter_describe(
    filter: *const sinew_filter,
    out_info: *mut sinew_filter_info,
    out_error: *mut sinew_error,
) -> sinew_status {
    let answer = |filter: &Filter<'_>| {
        let fit = filter.fit();
        Ok(sinew_filter_info {
            name: filter.name().as_ptr().cast(),
            name_len: filter.name().len(),
            part: filter.part() as u32,
            factor: filter.factor(),
            tap_len: filter.tap_len(),
            step: fit.step,
            left_out_rms: fit.left_out_rms,
            linear_rms: fit.linear_rms,
        })
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { part::describe(filter, out_info, out_error, answer) }
}

/// Makes samples `sinew_filter_info.factor` times as fine. Two calls make an image finer, one along its columns and one
/// along its rows.
///
/// - `shape`: how the samples lie.
/// - `samples`, `samples_len`: the numbers.
/// - `out_samples`, `out_len`: factor times as many; they lie likewise, with factor times as many samples a signal.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_filter_apply(
    filter: *const sinew_filter,
    shape: *const sinew_samples,
    samples: *const f32,
    samples_len: usize,
    out_samples: *mut f32,
    out_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (filter, [own, model, file]) = unsafe { part::view(filter) }?;
        // SAFETY: lent by the caller.
        let (shape, shape_span) = unsafe { border::copied(shape, sinew_argument::Shape) }?;
        let samples = Array::new(samples, samples_len, sinew_argument::Samples)?;
        let out = Array::new(out_samples, out_len, sinew_argument::Outputs)?;
        border::apart(&[out.span()], &[own, model, file, shape_span, samples.span()])?;
        let sinew_samples { signal_len, sample_len, lane_len } = shape;
        let shape = Samples { signal_len, sample_len, lane_len };
        // SAFETY: lent by the caller; what is written is apart from all else.
        Ok(filter.apply(shape, unsafe { samples.read() }, unsafe { out.write() })?)
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}
