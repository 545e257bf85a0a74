//! Filters: opens, describes and applies a filter.

use crate::argument::sinew_argument;
use crate::border::{self, Array, Loaded};
use crate::error::{sinew_error, sinew_status};
use crate::part::{self, Opened};
use core::ffi::c_char;
use sinew_runtime::Filter;
use sinew_runtime::filter::Samples;

/// Weights that upsample a signal.
///
/// The filter points to its model. Every call refuses the filter once the model was cleared or has loaded
/// another file.
pub struct sinew_filter(Loaded<Opened>);

part::part! { sinew_filter: Filter, tag b"SnwF", argument Filter }

/// Counts and measured errors of a filter.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_filter_info {
    /// Name in UTF-8, in the file's bytes, without a terminating zero.
    pub name: *const c_char,
    /// Length of the name in bytes.
    pub name_len: usize,
    /// Index among the file's parts.
    pub part: u32,
    /// F, fine samples per coarse sample.
    pub factor: usize,
    /// N, coarse samples that each fine sample is computed from. A signal needs at least N samples.
    pub tap_len: usize,
    /// Distance between coarse samples, in the unit of the signal's axis; 0 if the axis has no unit.
    pub step: f32,
    /// RMS error over left-out samples, in the signal's unit; 0 if not measured.
    pub left_out_rms: f32,
    /// RMS error of linear interpolation over these samples.
    pub linear_rms: f32,
}

/// Layout of samples: signals one after another, each of samples one after another, each of lanes side by
/// side.
///
/// An image has H rows of W pixels of C channels. Along its columns it is one signal of H samples with W *
/// C lanes; along its rows it is H signals of W samples with C lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_samples {
    /// Number of signals.
    pub signal_len: usize,
    /// Number of samples per signal.
    pub sample_len: usize,
    /// Number of lanes per sample. The filter treats each lane separately.
    pub lane_len: usize,
}

/// Describes a filter.
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

/// Upsamples signals by `sinew_filter_info.factor`. An image takes two calls, along its columns and along
/// its rows.
///
/// - `shape`: layout of the samples.
/// - `samples`, `samples_len`: the numbers.
/// - `out_samples`, `out_len`: receives factor times as many numbers, in the layout of `shape` with factor
///   times as many samples per signal.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`, `TOO_LONG`,
/// `OVERLAP`.
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
        border::check_disjoint(&[out.span()], &[own, model, file, shape_span, samples.span()])?;
        let sinew_samples { signal_len, sample_len, lane_len } = shape;
        let shape = Samples { signal_len, sample_len, lane_len };
        // SAFETY: lent by the caller; written memory overlaps nothing else.
        Ok(filter.apply(shape, unsafe { samples.read() }, unsafe { out.write() })?)
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}
