//! The kernel functions and their arguments.

use super::arena::bytes;
use super::call::Call;
use super::shared::{optional, unknown};
use arbitrary::Result;
use sinew_capi::*;
use std::ptr::null_mut;

use sinew_argument as Argument;
use sinew_status as Status;

pub(super) fn describe(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (kernel, out) = (call.kernel()?, call.output_one(Argument::Result)?);
    let error = call.ready(unknown);
    // SAFETY: as for each call of `functions`.
    Ok(unsafe { sinew_kernel_describe(kernel, out, error) })
}

pub(super) fn input(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let kernel = call.kernel()?;
    let input = call.number(call.arena.frame.input_len, Argument::Input)?;
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_kernel_input(kernel, input, out, error) })
}

pub(super) fn output(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let kernel = call.kernel()?;
    let output = call.number(call.arena.frame.output_len, Argument::Output)?;
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_kernel_output(kernel, output, out, error) })
}

pub(super) fn evaluate(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let Drawn { kernel, query, query_len, scratch, scratch_len, out, out_len } =
        drawn(call, 0, Argument::Outputs)?;
    let confidence =
        if call.one_in(4)? { null_mut() } else { optional(call, Argument::Confidences)? };
    let error = call.ready(|arena| bytes(arena.frame.ways[0].found.iter().copied()));
    // SAFETY: as above.
    Ok(unsafe {
        sinew_kernel_evaluate(
            kernel,
            query,
            query_len,
            scratch,
            scratch_len,
            out,
            out_len,
            confidence,
            error,
        )
    })
}

pub(super) fn jacobian(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    by(call, 1, sinew_kernel_jacobian, Argument::Jacobian)
}

pub(super) fn variance(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    by(call, 2, sinew_kernel_variance, Argument::Variances)
}

/// A function that evaluates a query.
type Way = unsafe extern "C" fn(
    *const sinew_kernel,
    *const f32,
    usize,
    *mut f32,
    usize,
    *mut f32,
    usize,
    *mut sinew_error,
) -> sinew_status;

fn by(
    call: &mut Call<'_, '_>,
    way: usize,
    function: Way,
    argument: Argument,
) -> Result<sinew_status> {
    let Drawn { kernel, query, query_len, scratch, scratch_len, out, out_len } =
        drawn(call, way, argument)?;
    let error = call.ready(|arena| bytes(arena.frame.ways[way].found.iter().copied()));
    // SAFETY: as above.
    Ok(unsafe { function(kernel, query, query_len, scratch, scratch_len, out, out_len, error) })
}

/// Arguments of an evaluation.
struct Drawn {
    kernel: *const sinew_kernel,
    query: *const f32,
    query_len: usize,
    scratch: *mut f32,
    scratch_len: usize,
    out: *mut f32,
    out_len: usize,
}

/// Draws the arguments for one way to evaluate a kernel.
fn drawn(call: &mut Call<'_, '_>, way: usize, argument: Argument) -> Result<Drawn> {
    let way = &call.arena.frame.ways[way];
    let (refusal, len, least) = (way.refusal, way.found.len(), way.scratch_len);
    match refusal {
        Some(refusal) if refusal.status == Status::NoAttribute => {
            call.fault(refusal.status, refusal.argument);
        }
        // The drawn query may differ from the frame's, and then have a result.
        refusal => call.maybe_faulty |= refusal.is_some(),
    }
    call.spoil(call.arena.query.clone())?;
    let (kernel, r) = (call.kernel()?, call.arena.frame.query.len());
    let (query, query_len) = call.input(call.arena.query.clone(), r, Argument::Query)?;
    let (out, out_len) = call.output_exact(len, len, argument)?;
    let (scratch, scratch_len) = call.output(least, Argument::Scratch)?;
    call.used = call.arena.place(scratch, scratch_len);
    Ok(Drawn { kernel, query, query_len, scratch, scratch_len, out, out_len })
}
