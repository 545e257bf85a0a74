//! Kernels: opens, describes and evaluates a kernel.

use crate::argument::sinew_argument;
use crate::border::{Array, Loaded};
use crate::error::{sinew_error, sinew_status};
use crate::part::{self, Evaluation, Opened};
use core::ffi::c_char;
use sinew_runtime::KernelMap;

/// A function from named inputs to named outputs.
///
/// The kernel points to its model. Every call refuses the kernel once the model was cleared or has loaded
/// another file.
pub struct sinew_kernel(Loaded<Opened>);

part::part! { sinew_kernel: KernelMap, tag b"SnwK", argument Kernel }

/// Measured errors of a kernel's fit, in the units of its outputs.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_kernel_fit {
    /// RMS residual over the samples.
    pub rms_residual: f32,
    /// Left-out RMS error: the prediction of each sample comes from a fit without the sample; 0 if not
    /// computed.
    pub left_out_rms: f32,
    /// Largest bound found on rounding errors in single precision.
    pub rounding_error: f32,
    /// Reciprocal condition number of the linear system.
    pub reciprocal_condition: f32,
}

/// Counts of a kernel, and the lengths of all arrays that its calls take.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_kernel_info {
    /// Name in UTF-8, in the file's bytes, without a terminating zero.
    pub name: *const c_char,
    /// Length of the name in bytes.
    pub name_len: usize,
    /// Index among the file's parts.
    pub part: u32,
    /// Number of the kernel function in FORMAT.md.
    pub kernel: u32,
    /// Number of inputs.
    pub input_len: usize,
    /// Number of outputs.
    pub output_len: usize,
    /// R, the length of a query: all numbers of all inputs.
    pub query_len: usize,
    /// Length of a result: all numbers of all outputs.
    pub result_len: usize,
    /// m, the number of values that outputs are computed from. A rotation has 3 values. Jacobian and
    /// variances are those of the values.
    pub value_len: usize,
    /// Floats of scratch that `sinew_kernel_evaluate` needs.
    pub scratch_len: usize,
    /// Floats of scratch that `sinew_kernel_jacobian` needs.
    pub jacobian_scratch_len: usize,
    /// Floats of scratch that `sinew_kernel_variance` needs.
    pub variance_scratch_len: usize,
    /// 1 if the kernel can compute a variance, otherwise 0.
    pub has_variance: u32,
    /// Measured errors of the fit.
    pub fit: sinew_kernel_fit,
}

/// An input or an output of a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_quantity {
    /// Name in UTF-8, in the file's bytes, without a terminating zero.
    pub name: *const c_char,
    /// Length of the name in bytes.
    pub name_len: usize,
    /// Number of the kind in FORMAT.md's table of inputs or of outputs.
    pub kind: u32,
    /// Number of floats: 1 for a scalar, 3 for a vector, 4 for a rotation (quaternion x, y, z, w).
    pub number_len: usize,
}

/// Describes a kernel.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_kernel_describe(
    kernel: *const sinew_kernel,
    out_info: *mut sinew_kernel_info,
    out_error: *mut sinew_error,
) -> sinew_status {
    // SAFETY: the caller's promise is passed on.
    unsafe { part::describe(kernel, out_info, out_error, |kernel| Ok(info(kernel))) }
}

/// Describes an input. Inputs have the order of a query.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`, `OUT_OF_RANGE`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_kernel_input(
    kernel: *const sinew_kernel,
    input: usize,
    out_input: *mut sinew_quantity,
    out_error: *mut sinew_error,
) -> sinew_status {
    let answer = |kernel: &KernelMap<'_>| {
        let len = kernel.counts().input_len as usize;
        let outside = sinew_error::out_of_range(sinew_argument::Input, input, len);
        let found = kernel.input_name(input).zip(kernel.inputs().nth(input));
        let (name, row) = found.ok_or(outside)?;
        Ok(quantity(name, row.kind.number(), row.kind.number_len()))
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { part::describe(kernel, out_input, out_error, answer) }
}

/// Describes an output. Outputs have the order of a result.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`, `OUT_OF_RANGE`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_kernel_output(
    kernel: *const sinew_kernel,
    output: usize,
    out_output: *mut sinew_quantity,
    out_error: *mut sinew_error,
) -> sinew_status {
    let answer = |kernel: &KernelMap<'_>| {
        let len = kernel.counts().output_len as usize;
        let outside = sinew_error::out_of_range(sinew_argument::Output, output, len);
        let found = kernel.output_name(output).zip(kernel.outputs().nth(output));
        let (name, row) = found.ok_or(outside)?;
        Ok(quantity(name, row.kind.number(), row.kind.number_len()))
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { part::describe(kernel, out_output, out_error, answer) }
}

/// Computes the outputs of a query and their confidence.
///
/// - `query`, `query_len`: `sinew_kernel_info.query_len` numbers, one input after another; a rotation is a
///   quaternion of any length but 0.
/// - `scratch`, `scratch_len`: at least `sinew_kernel_info.scratch_len` floats with any content, one array
///   per thread. The content after the call has no meaning.
/// - `out_numbers`, `out_len`: receives `sinew_kernel_info.result_len` numbers, one output after another; a
///   rotation is a quaternion of length 1.
/// - `out_confidence`: null, or receives the confidence: 1 near the centres, falling to 0 far from all. A
///   kernel without a fade gives 1.
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
    let evaluation = Evaluation {
        input: Array::new(query, query_len, sinew_argument::Query),
        curves: Array::none(),
        scratch: Array::new(scratch, scratch_len, sinew_argument::Scratch),
        output: Array::new(out_numbers, out_len, sinew_argument::Outputs),
        confidences: Array::optional(out_confidence, sinew_argument::Confidences),
    };
    // SAFETY: the caller's promise is passed on.
    unsafe {
        evaluation.run_one(kernel, out_error, |kernel, input, _, scratch, output| {
            kernel.evaluate(input, scratch, output)
        })
    }
}

/// Computes the derivatives of the m values with respect to the R numbers of a query. The values are those
/// before fade, ranges and sums of outputs; for a rotation they are its rotation vector.
///
/// - `query`, `query_len`: as for `sinew_kernel_evaluate`.
/// - `scratch`, `scratch_len`: at least `sinew_kernel_info.jacobian_scratch_len` floats, as for
///   `sinew_kernel_evaluate`.
/// - `out_jacobian`, `jacobian_len`: receives m rows of R derivatives.
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
    let evaluation = Evaluation {
        input: Array::new(query, query_len, sinew_argument::Query),
        curves: Array::none(),
        scratch: Array::new(scratch, scratch_len, sinew_argument::Scratch),
        output: Array::new(out_jacobian, jacobian_len, sinew_argument::Jacobian),
        confidences: Array::none(),
    };
    // SAFETY: the caller's promise is passed on.
    unsafe {
        evaluation.run(kernel, out_error, |kernel, input, _, scratch, output, _| {
            kernel.jacobian(input, scratch, output)
        })
    }
}

/// Computes the variance of each of the m values, before fade, ranges and sums of outputs.
///
/// - `query`, `query_len`: as for `sinew_kernel_evaluate`.
/// - `scratch`, `scratch_len`: at least `sinew_kernel_info.variance_scratch_len` floats, as for
///   `sinew_kernel_evaluate`.
/// - `out_variances`, `variances_len`: receives m variances, which are not negative.
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
    let evaluation = Evaluation {
        input: Array::new(query, query_len, sinew_argument::Query),
        curves: Array::none(),
        scratch: Array::new(scratch, scratch_len, sinew_argument::Scratch),
        output: Array::new(out_variances, variances_len, sinew_argument::Variances),
        confidences: Array::none(),
    };
    // SAFETY: the caller's promise is passed on.
    unsafe {
        evaluation.run(kernel, out_error, |kernel, input, _, scratch, output, _| {
            kernel.variance(input, scratch, output)
        })
    }
}

/// Describes an input or an output.
fn quantity(name: &str, kind: u8, number_len: usize) -> sinew_quantity {
    sinew_quantity {
        name: name.as_ptr().cast(),
        name_len: name.len(),
        kind: kind.into(),
        number_len,
    }
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
