//! The uniform block: counts, and where each array lies in its binding, in words of 4 bytes.

use super::array::Array;
use super::chunk::{Param, Spans};
use super::demand::{Demand, Member, NONE};

impl Demand {
    /// Returns the bytes of the block: its members, up to a whole number of vectors of four.
    pub(super) fn param_bytes(&self) -> u64 {
        (4 * self.members.len() as u64).next_multiple_of(16)
    }

    /// Lists the members of a chunk's block, in the order in which they lie in it.
    ///
    /// - `first`: the chunk's first instance.
    pub(super) fn params(&self, first: usize, spans: &Spans) -> Vec<Param> {
        let value = |member: Member| match member {
            Member::Number(number) => number,
            Member::Offset(resource, array) => {
                let (Some(Array { offset, stride }), Some(span)) =
                    (array, spans[resource as usize])
                else {
                    return NONE;
                };
                let at = (first as u64).saturating_mul(stride as u64).saturating_add(offset as u64);
                at.saturating_sub(span.offset / 4) as usize
            }
        };
        let members = self.members.iter();
        // What lies within a binding has 30 bits; a longer stride is never taken.
        let narrow = |value: usize| u32::try_from(value).unwrap_or(u32::MAX);
        members.map(|&(name, member)| (name, narrow(value(member)))).collect()
    }
}
