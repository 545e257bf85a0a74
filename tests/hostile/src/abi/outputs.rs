//! Where jobs write attributes of vertices.

use super::call::Call;
use arbitrary::Result;
use sinew_capi::*;
use std::ptr::null_mut;

use sinew_argument as Argument;
use sinew_status as Status;

/// Floats of a vertex in the outputs' room.
pub(super) const FLOATS: usize = 12;

pub(super) type Outputs = ([sinew_output; 3], [Option<(usize, usize)>; 3]);

/// Draws outputs: interleaved in one room, or over each other, some left out, or astray. Returns also
/// the first float and the stride of each.
pub(super) fn outputs(call: &mut Call<'_, '_>, n: usize, has_tangents: bool) -> Result<Outputs> {
    let room = call.result_place(4 * FLOATS * n);
    let mut outputs = [sinew_output { floats: null_mut(), len: 0, stride: 0 }; 3];
    let mut asked = [None; 3];
    for (i, (own, first, argument)) in
        [(3, 0, Argument::Positions), (3, 3, Argument::Normals), (4, 6, Argument::Tangents)]
            .into_iter()
            .enumerate()
    {
        if call.one_in(3)? || (own == 4 && !has_tangents && !call.one_in(8)?) {
            continue;
        }
        let mut stride = call.u.int_in_range(own..=FLOATS - 2)?;
        if call.one_in(16)? {
            stride = call.u.int_in_range(0..=own)?;
        }
        // Within the room whatever the stride: of no vertex there is none.
        let first = if call.one_in(8)? { call.u.int_in_range(0..=2)? } else { first };
        let first = if n == 0 { 0 } else { first.min(FLOATS - own) };
        let place = room.start + 4 * first..room.end;
        let len = place.len() / 4;
        let least = n.checked_sub(1).map_or(0, |last| last * stride + own);
        let (floats, len) = call.output_at(place, len, least, stride < own, argument)?;
        outputs[i] = sinew_output { floats, len, stride };
        asked[i] = (!floats.is_null() || len > 0).then_some((first, stride));
        let is_asked = asked[i].is_some();
        call.fault_if(!is_asked && stride > 0, Status::Null, argument);
        call.fault_if(is_asked && stride < own, Status::Stride, argument);
        call.fault_if(is_asked && own == 4 && !has_tangents, Status::NoAttribute, argument);
    }
    let nothing = asked.iter().all(Option::is_none);
    call.fault_if(nothing, Status::NoOutput, Argument::Call);
    Ok((outputs, asked))
}
