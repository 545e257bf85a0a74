//! What functions of several parts take: which part is wanted, results that may go nowhere.

use super::arena::{Arena, BATCH, BLANK, Since, result_after};
use super::call::Call;
use arbitrary::Result;
use sinew_capi::*;
use std::ffi::c_char;
use std::ops::Range;
use std::ptr::null;

use sinew_argument as Argument;
use sinew_status as Status;

/// Nothing that this module compares: the C ABI's own tests do.
pub(super) fn unknown(_: &Arena) -> Vec<u8> {
    Vec::new()
}

/// The place of the first pose.
pub(super) fn one_pose(call: &Call<'_, '_>) -> Range<usize> {
    let Range { start, end } = call.arena.poses;
    start..start + (end - start) / BATCH
}

/// The same, with a float in it that may be none.
pub(super) fn spoilt_pose(call: &mut Call<'_, '_>) -> Result<Range<usize>> {
    let one = one_pose(call);
    call.spoil(one.clone())?;
    Ok(one)
}

/// Draws which part is wanted: any or one of the part's own name, or of bytes that are none; the first,
/// or one beyond all.
pub(super) fn wanted(
    call: &mut Call<'_, '_>,
    is_there: bool,
    own: String,
    argument: Argument,
) -> Result<(*const c_char, usize, usize)> {
    // The other file has parts of its own, by the same names or others.
    let is_other = call.arena.since != Since::Nothing;
    call.fault_if(!is_there && !is_other, Status::NotFound, argument);
    call.vague |= is_other;
    let index = if call.one_in(8)? { usize::MAX } else { 0 };
    call.fault_if(index > 0, Status::NotFound, argument);
    if call.one_in(2)? {
        let len = if call.one_in(2)? { 0 } else { usize::MAX };
        call.fault_if(len > 0, Status::Null, Argument::Name);
        return Ok((null(), len, index));
    }
    let start = call.arena.argument.start;
    let mut name = own.into_bytes();
    if call.one_in(4)? {
        name.reverse();
        call.vague = true;
    }
    call.arena.write(start, &name);
    let drawn = call.faults.len();
    let (at, len) = call.input_any::<c_char>(start..start + name.len(), Argument::Name)?;
    if at.is_null() && len == 0 {
        // That is any name, and no fault.
        call.faults.truncate(drawn);
    }
    Ok((at, len, index))
}

/// Draws one value that is read, or none, which is no fault.
pub(super) fn optional_input<T>(
    call: &mut Call<'_, '_>,
    place: usize,
    argument: Argument,
) -> Result<*const T> {
    let drawn = call.faults.len();
    let at = call.input_one::<T>(place, argument)?;
    if at.is_null() {
        call.faults.truncate(drawn);
    }
    Ok(at)
}

/// Draws where one result goes that may go nowhere.
pub(super) fn optional<T>(call: &mut Call<'_, '_>, argument: Argument) -> Result<*mut T> {
    let drawn = call.faults.len();
    let out = call.output_one::<T>(argument)?;
    if out.is_null() {
        call.faults.truncate(drawn);
    }
    Ok(out)
}

/// Lays out what results must hold, in the order in which they were drawn.
pub(super) fn laid<const N: usize>(results: [Vec<u8>; N]) -> Vec<u8> {
    let mut out = Vec::new();
    for (at, result) in results.into_iter().enumerate() {
        if at > 0 {
            out.resize(result_after(out.len()), BLANK);
        }
        out.extend(result);
    }
    out
}
