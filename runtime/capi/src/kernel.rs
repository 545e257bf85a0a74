//! A kernel, what the file says of it, and its evaluation.

use crate::argument::sinew_argument;
use crate::border::{self, Array, Loaded};
use crate::error::sinew_error;
use crate::model::sinew_model;
use crate::part::{self, Opened, Wanted};
use crate::status::sinew_status;
use core::ffi::{c_char, c_void};
use core::mem::{align_of, size_of};
use sinew_runtime::kernel::KernelLayout;
use sinew_runtime::{CallError, KernelMap};

/// Elements of a `uintptr_t` array that holds a kernel on every target:
/// `uintptr_t memory[SINEW_KERNEL_WORDS]`.
pub const SINEW_KERNEL_WORDS: usize = 48;

/// A function from named inputs to named outputs. It points to its model: where that has been loaded again
/// with another file, or is loaded no more, every call refuses the kernel.
pub struct sinew_kernel(Loaded<Opened<KernelLayout>>);

part::part! {
    sinew_kernel: KernelLayout to KernelMap, of Model::kernels,
    tag b"SnwK", argument Kernel, within SINEW_KERNEL_WORDS
}

/// What a kernel's fit was measured to reach, in the units of its outputs.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_kernel_fit {
    /// RMS over the samples of how far the values are from theirs.
    pub rms_residual: f32,
    /// The same, each sample left out of its own fit; 0 if it was not computed.
    pub left_out_rms: f32,
    /// The largest bound on errors of single precision that was found.
    pub rounding_error: f32,
    /// Reciprocal of the condition number of what was solved.
    pub reciprocal_condition: f32,
}

/// What a kernel is made of: every length that its calls need.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_kernel_info {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    pub name: *const c_char,
    /// Bytes of the name.
    pub name_len: usize,
    /// Its number among the file's parts.
    pub part: u32,
    /// The number of its function in FORMAT.md's table of kernels.
    pub kernel: u32,
    /// Inputs.
    pub input_len: usize,
    /// Outputs.
    pub output_len: usize,
    /// R, numbers of a query: those of the inputs together.
    pub query_len: usize,
    /// Numbers of the outputs together.
    pub result_len: usize,
    /// m, values: what outputs are made of, and what a Jacobian and variances are of. A rotation has 3.
    pub value_len: usize,
    /// Floats of scratch that `sinew_kernel_evaluate` needs.
    pub scratch_len: usize,
    /// Floats of scratch that `sinew_kernel_jacobian` needs.
    pub jacobian_scratch_len: usize,
    /// Floats of scratch that `sinew_kernel_variance` needs.
    pub variance_scratch_len: usize,
    /// 1 if it holds what a variance is computed of, else 0.
    pub has_variance: u32,
    /// What the fit was measured to reach.
    pub fit: sinew_kernel_fit,
}

/// An input or an output of a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_quantity {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    pub name: *const c_char,
    /// Bytes of the name.
    pub name_len: usize,
    /// Its number in FORMAT.md's table of inputs, or of outputs.
    pub kind: u32,
    /// Its numbers: 1 of a scalar, 3 of a vector, of a rotation the 4 of a quaternion x, y, z, w.
    pub number_len: usize,
}

/// Returns the bytes of memory that a kernel needs: at most those of `SINEW_KERNEL_WORDS` words.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_kernel_bytes() -> usize {
    size_of::<sinew_kernel>()
}

/// Opens a kernel of a model.
///
/// - `name`, `name_len`: its name, without a zero at its end; null and 0 for any.
/// - `index`: which of those; 0 for the first.
/// - `memory`, `memory_bytes`: for the kernel; at least `sinew_kernel_bytes()`, aligned as a `uintptr_t`.
/// - `out_kernel`: receives the handle, which is `memory`.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`, `NOT_LOADED`, `NOT_FOUND`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_kernel_open(
    model: *const sinew_model,
    name: *const c_char,
    name_len: usize,
    index: usize,
    memory: *mut c_void,
    memory_bytes: usize,
    out_kernel: *mut *const sinew_kernel,
    out_error: *mut sinew_error,
) -> sinew_status {
    let wanted = Wanted { name, name_len, index };
    // SAFETY: the caller's promise is passed on.
    let body = || unsafe { part::open(model, &wanted, memory, memory_bytes, out_kernel) };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Says what a kernel is made of.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_kernel_describe(
    kernel: *const sinew_kernel,
    out_info: *mut sinew_kernel_info,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (kernel, reads) = unsafe { part::view(kernel) }?;
        let out = Array::one(out_info, sinew_argument::Result)?;
        border::apart(&[out.span()], &reads)?;
        let info = info(&kernel);
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(info) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Describes an input, in the order of a query.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`, `OUT_OF_RANGE`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_kernel_input(
    kernel: *const sinew_kernel,
    input: usize,
    out_input: *mut sinew_quantity,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let row = |kernel: &KernelMap<'static>| {
            let row = kernel.inputs().nth(input)?;
            Some((kernel.input_name(input)?, row.kind.number(), row.kind.number_len()))
        };
        let len = |kernel: &KernelMap<'static>| kernel.counts().input_len;
        // SAFETY: the caller's promise is passed on.
        unsafe { quantity(kernel, (sinew_argument::Input, input), out_input, row, len) }
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Describes an output, in the order in which they are given.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`, `OUT_OF_RANGE`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_kernel_output(
    kernel: *const sinew_kernel,
    output: usize,
    out_output: *mut sinew_quantity,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let row = |kernel: &KernelMap<'static>| {
            let row = kernel.outputs().nth(output)?;
            Some((kernel.output_name(output)?, row.kind.number(), row.kind.number_len()))
        };
        let len = |kernel: &KernelMap<'static>| kernel.counts().output_len;
        // SAFETY: the caller's promise is passed on.
        unsafe { quantity(kernel, (sinew_argument::Output, output), out_output, row, len) }
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Computes the outputs of a query and the confidence in them.
///
/// - `query`, `query_len`: `sinew_kernel_info.query_len` numbers, one input after the other; of a rotation a
///   quaternion of any length but 0.
/// - `scratch`, `scratch_len`: at least `sinew_kernel_info.scratch_len` floats, of any content; its content
///   afterwards means nothing. One for each thread.
/// - `out_numbers`, `out_len`: `sinew_kernel_info.result_len` numbers, one output after the other; of a rotation
///   a quaternion of length 1.
/// - `out_confidence`: null, or receives 1 near the centres down to 0 far from all; 1 of a kernel that has no
///   fade.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`,
/// `ZERO_ROTATION`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_kernel_evaluate(
    kernel: *const sinew_kernel,
    query: *const f32,
    query_len: usize,
    scratch: *mut f32,
    scratch_len: usize,
    out_numbers: *mut f32,
    out_len: usize,
    out_confidence: *mut f32,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let query = Array::new(query, query_len, sinew_argument::Query);
        let scratch = Array::new(scratch, scratch_len, sinew_argument::Scratch);
        let out = Array::new(out_numbers, out_len, sinew_argument::Outputs);
        let confidence = Array::optional(out_confidence, sinew_argument::Confidences);
        // SAFETY: the caller's promise is passed on.
        unsafe {
            evaluate(kernel, query, scratch, out, confidence, |kernel, arrays| {
                let Arrays { query, scratch, out, confidence } = arrays;
                let found = kernel.evaluate(query, scratch, out)?;
                confidence.fill(found);
                Ok(())
            })
        }
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Computes the derivatives of the m values by the R numbers of a query: before the fade, ranges and sums of
/// outputs, so that those of a rotation are its vector's.
///
/// - `query`, `query_len`: as for `sinew_kernel_evaluate`.
/// - `scratch`, `scratch_len`: at least `sinew_kernel_info.jacobian_scratch_len` floats, likewise.
/// - `out_jacobian`, `jacobian_len`: m rows of R derivatives.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`,
/// `ZERO_ROTATION`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_kernel_jacobian(
    kernel: *const sinew_kernel,
    query: *const f32,
    query_len: usize,
    scratch: *mut f32,
    scratch_len: usize,
    out_jacobian: *mut f32,
    jacobian_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let query = Array::new(query, query_len, sinew_argument::Query);
        let scratch = Array::new(scratch, scratch_len, sinew_argument::Scratch);
        let out = Array::new(out_jacobian, jacobian_len, sinew_argument::Jacobian);
        let nothing = Array::optional(core::ptr::null(), sinew_argument::Confidences);
        // SAFETY: the caller's promise is passed on.
        unsafe {
            evaluate(kernel, query, scratch, out, nothing, |kernel, arrays| {
                kernel.jacobian(arrays.query, arrays.scratch, arrays.out)
            })
        }
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Computes the variance of each of the m values, before the fade, ranges and sums of outputs.
///
/// - `query`, `query_len`: as for `sinew_kernel_evaluate`.
/// - `scratch`, `scratch_len`: at least `sinew_kernel_info.variance_scratch_len` floats, likewise.
/// - `out_variances`, `variances_len`: m variances, not negative.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `NO_ATTRIBUTE`, `LENGTH`, `TOO_SHORT`,
/// `NON_FINITE`, `ZERO_ROTATION`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_kernel_variance(
    kernel: *const sinew_kernel,
    query: *const f32,
    query_len: usize,
    scratch: *mut f32,
    scratch_len: usize,
    out_variances: *mut f32,
    variances_len: usize,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let query = Array::new(query, query_len, sinew_argument::Query);
        let scratch = Array::new(scratch, scratch_len, sinew_argument::Scratch);
        let out = Array::new(out_variances, variances_len, sinew_argument::Variances);
        let nothing = Array::optional(core::ptr::null(), sinew_argument::Confidences);
        // SAFETY: the caller's promise is passed on.
        unsafe {
            evaluate(kernel, query, scratch, out, nothing, |kernel, arrays| {
                kernel.variance(arrays.query, arrays.scratch, arrays.out)
            })
        }
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Stores the description of an input or of an output: its name, its kind, and how many numbers it has.
///
/// # Safety
/// The handle is null or points to memory as large as a kernel; what is stored is the caller's to be written.
unsafe fn quantity(
    kernel: *const sinew_kernel,
    (argument, number): (sinew_argument, usize),
    out: *mut sinew_quantity,
    row: impl Fn(&KernelMap<'static>) -> Option<(&'static str, u8, usize)>,
    len: impl Fn(&KernelMap<'static>) -> u32,
) -> Result<(), sinew_error> {
    // SAFETY: the caller's promise is passed on.
    let (kernel, reads) = unsafe { part::view(kernel) }?;
    let out = Array::one(out, sinew_argument::Result)?;
    border::apart(&[out.span()], &reads)?;
    let most = (len(&kernel) as usize).saturating_sub(1);
    let beyond = sinew_error::new(sinew_status::OutOfRange, argument).values(most, number);
    let (name, kind, number_len) = row(&kernel).ok_or(beyond)?;
    let found = sinew_quantity {
        name: name.as_ptr().cast(),
        name_len: name.len(),
        kind: kind.into(),
        number_len,
    };
    // SAFETY: one element, which the caller lets be written.
    unsafe { out.store(found) };
    Ok(())
}

/// An array, or what is wrong with it, which is told after what is wrong with the kernel.
type Checked = Result<Array<f32>, sinew_error>;

/// What is computed of and into; a confidence goes where there is room for it.
struct Arrays<'a> {
    query: &'a [f32],
    scratch: &'a mut [f32],
    out: &'a mut [f32],
    confidence: &'a mut [f32],
}

/// Evaluates a kernel by one of the runtime's ways.
///
/// # Safety
/// The handle is null or points to memory as large as a kernel; the arrays are the caller's to read and
/// to write.
unsafe fn evaluate(
    kernel: *const sinew_kernel,
    query: Checked,
    scratch: Checked,
    out: Checked,
    confidence: Checked,
    way: impl FnOnce(&KernelMap<'_>, Arrays<'_>) -> Result<(), CallError>,
) -> Result<(), sinew_error> {
    // SAFETY: the caller's promise is passed on.
    let (kernel, [own, model, file]) = unsafe { part::view(kernel) }?;
    let (query, scratch, out, confidence) = (query?, scratch?, out?, confidence?);
    border::apart(
        &[scratch.span(), out.span(), confidence.span()],
        &[own, model, file, query.span()],
    )?;
    // SAFETY: lent by the caller; what is written is apart from all else.
    let arrays = unsafe {
        Arrays {
            query: query.read(),
            scratch: scratch.write(),
            out: out.write(),
            confidence: confidence.write(),
        }
    };
    Ok(way(&kernel, arrays)?)
}

fn info(kernel: &KernelMap<'_>) -> sinew_kernel_info {
    let (counts, fit) = (kernel.counts(), kernel.fit());
    sinew_kernel_info {
        name: kernel.name().as_ptr().cast(),
        name_len: kernel.name().len(),
        part: kernel.part() as u32,
        kernel: kernel.rule().kernel.number().into(),
        input_len: counts.input_len as usize,
        output_len: counts.output_len as usize,
        query_len: kernel.query_len(),
        result_len: kernel.result_len(),
        value_len: counts.value_len as usize,
        scratch_len: counts.scratch_len(),
        jacobian_scratch_len: counts.jacobian_scratch_len(),
        variance_scratch_len: counts.variance_scratch_len(),
        has_variance: u32::from(kernel.has_variance()),
        fit: sinew_kernel_fit {
            rms_residual: fit.rms_residual,
            left_out_rms: fit.left_out_rms,
            rounding_error: fit.rounding_error,
            reciprocal_condition: fit.reciprocal_condition,
        },
    }
}
