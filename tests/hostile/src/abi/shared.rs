//! Arguments that functions of several parts share: the requested part, optional results, outputs
//! of jobs.

use super::arena::{Arena, BATCH, BLANK, Since, result_after};
use super::call::Call;
use arbitrary::Result;
use sinew_capi::*;
use std::ffi::c_char;
use std::ops::Range;
use std::ptr::{null, null_mut};

use sinew_argument as Argument;
use sinew_status as Status;

/// Expected bytes of a result that this module does not compare: the C ABI's tests do.
pub(super) fn unknown(_: &Arena) -> Vec<u8> {
    Vec::new()
}

/// Returns the place of the first pose.
pub(super) fn one_pose(call: &Call<'_, '_>) -> Range<usize> {
    let Range { start, end } = call.arena.poses;
    start..start + (end - start) / BATCH
}

/// Returns the place of the first pose, after possibly making one of its floats invalid.
pub(super) fn spoilt_pose(call: &mut Call<'_, '_>) -> Result<Range<usize>> {
    let one = one_pose(call);
    call.spoil(one.clone())?;
    Ok(one)
}

/// Returns the place of the curves of the first pose.
pub(super) fn one_curves(call: &Call<'_, '_>) -> Range<usize> {
    let Range { start, end } = call.arena.curves;
    start..start + (end - start) / BATCH
}

/// Draws the curves of the first pose, after possibly making one of them invalid.
pub(super) fn spoilt_curves(call: &mut Call<'_, '_>) -> Result<(*const f32, usize)> {
    let one = one_curves(call);
    call.spoil(one.clone())?;
    call.input(one, call.arena.frame.curves.len(), Argument::Curves)
}

/// Draws the requested part. Its name is null, the part's name, or bytes that name no part; its
/// index is 0 or too large.
pub(super) fn wanted(
    call: &mut Call<'_, '_>,
    is_there: bool,
    own: String,
    argument: Argument,
) -> Result<(*const c_char, usize, usize)> {
    // The other file has other parts, with equal or different names.
    let is_other = call.arena.since != Since::Nothing;
    call.fault_if(!is_there && !is_other, Status::NotFound, argument);
    call.maybe_faulty |= is_other;
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
        call.maybe_faulty = true;
    }
    call.arena.write(start, &name);
    let drawn = call.faults.len();
    let (at, len) = call.input_any::<c_char>(start..start + name.len(), Argument::Name)?;
    if at.is_null() && len == 0 {
        // A null name of length 0 matches every part: not a fault.
        call.faults.truncate(drawn);
    }
    Ok((at, len, index))
}

/// Draws one optional input value; a null pointer is not a fault.
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

/// Draws the pointer to one optional result.
pub(super) fn optional<T>(call: &mut Call<'_, '_>, argument: Argument) -> Result<*mut T> {
    let drawn = call.faults.len();
    let out = call.output_one::<T>(argument)?;
    if out.is_null() {
        call.faults.truncate(drawn);
    }
    Ok(out)
}

/// Lays out the expected results in the order in which they were drawn.
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

/// Whether two outputs of `n` vertices share a float, or, if their strides differ, a range.
fn overlap(a: (&sinew_output, usize), b: (&sinew_output, usize), n: usize) -> bool {
    if n == 0 || a.0.floats.is_null() || b.0.floats.is_null() {
        return false;
    }
    let vertex = |(output, own): (&sinew_output, usize), v: usize| {
        let start = output.floats.addr() + 4 * v * output.stride;
        start..start + 4 * own
    };
    let meet = |a: Range<usize>, b: Range<usize>| a.start < b.end && b.start < a.end;
    if a.0.stride != b.0.stride {
        let all = |output| vertex(output, 0).start..vertex(output, n - 1).end;
        return meet(all(a), all(b));
    }
    (0..n).any(|v| meet(vertex(a, v), vertex(b, 0)) || meet(vertex(a, 0), vertex(b, v)))
}

/// Floats per vertex in the room of the outputs.
pub(super) const FLOATS: usize = 12;

pub(super) type Outputs = ([sinew_output; 3], [Option<(usize, usize)>; 3]);

/// Attributes of outputs: their floats, and where they are in a vertex of the room.
const ATTRIBUTES: [(usize, usize, Argument); 3] =
    [(3, 0, Argument::Positions), (3, 3, Argument::Normals), (4, 6, Argument::Tangents)];

/// Draws outputs: interleaved in one room, overlapping, missing, or at a wrong address. Also
/// returns the first float and the stride of each output.
pub(super) fn outputs(call: &mut Call<'_, '_>, n: usize, has_tangents: bool) -> Result<Outputs> {
    let room = call.result_place(4 * FLOATS * n);
    let mut outputs = [sinew_output { floats: null_mut(), len: 0, stride: 0 }; 3];
    let mut requested = [None; 3];
    let common = call.u.int_in_range(4..=FLOATS - 2)?.max(call.u.int_in_range(4..=FLOATS - 2)?);
    for (i, (own, first, argument)) in ATTRIBUTES.into_iter().enumerate() {
        if call.one_in(3)? || (own == 4 && !has_tangents && !call.one_in(8)?) {
            continue;
        }
        let mut stride = common;
        if call.one_in(8)? {
            stride = call.u.int_in_range(own..=FLOATS - 2)?;
        }
        if call.one_in(16)? {
            stride = call.u.int_in_range(0..=own)?;
        }
        // Every output stays within the room for every stride; without vertices the room is empty.
        let first = if call.one_in(8)? { call.u.int_in_range(0..=2)? } else { first };
        let first = if n == 0 { 0 } else { first.min(FLOATS - own) };
        let place = room.start + 4 * first..room.end;
        let len = place.len() / 4;
        let least = n.checked_sub(1).map_or(0, |last| last * stride + own);
        let (floats, len) = call.output_at(place, len, least, stride < own, argument)?;
        outputs[i] = sinew_output { floats, len, stride };
        requested[i] = (!floats.is_null() || len > 0).then_some((first, stride));
        let is_requested = requested[i].is_some();
        call.fault_if(!is_requested && stride > 0, Status::Null, argument);
        call.fault_if(is_requested && stride < own, Status::Stride, argument);
        call.fault_if(is_requested && own == 4 && !has_tangents, Status::NoAttribute, argument);
    }
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        let [a, b] = [i, j].map(|of| (&outputs[of], ATTRIBUTES[of].0));
        call.fault_if(overlap(a, b, n), Status::Overlap, ATTRIBUTES[j].2);
    }
    let nothing = requested.iter().all(Option::is_none);
    call.fault_if(nothing, Status::NoOutput, Argument::Call);
    Ok((outputs, requested))
}
