//! A record in a loaded file: what loading found of it, and what it holds.

use super::counts::{MARK_LEN, RULES, RecordCounts};
use crate::format::SectionKind;
use crate::format::part::{self, Part, first_counts};
use crate::format::rule::Rule;
use crate::linear::floats;
use crate::names::Names;

const NAMES: usize = Rule::place(&RULES, SectionKind::Names);
const MARKS: usize = Rule::place(&RULES, SectionKind::FrameMarks);
const JOINTS: usize = Rule::place(&RULES, SectionKind::LbsJoints);
const WEIGHTS: usize = Rule::place(&RULES, SectionKind::LbsWeights);

/// What an envelope of the record's name was trained on; borrowed from a loaded model.
///
/// Accessors by number return `None` beyond their range.
#[derive(Clone, Copy)]
pub struct Record<'a>(pub(crate) Part<'a>);

part::view! { Record, RecordLayout, |words| -> RecordCounts { RecordCounts::from_words(first_counts(words)) } }

impl<'a> Record<'a> {
    /// Lists the marks of the training frames: numbers by which a frame is known again, in any axes and unit
    /// (METHOD §1.11).
    pub fn frame_marks(&self) -> impl ExactSizeIterator<Item = [f32; MARK_LEN]> + use<'a> {
        self.0.array(MARKS).iter().map(floats)
    }

    /// Lists the joints that a vertex follows in the linear blend skinning that was fitted to the training frames,
    /// each with its weight; they sum to 1 but for rounding. Of a record without weights there are none.
    pub fn lbs_influences(
        &self,
        vertex: usize,
    ) -> Option<impl ExactSizeIterator<Item = (usize, f32)> + use<'a>> {
        let counts = self.counts();
        let most = counts.influence_len as usize;
        if vertex >= counts.vertex_len as usize {
            return None;
        }
        let start = vertex.checked_mul(most)?;
        let halves = |place| self.halves(place).get(start..)?.get(..most);
        let (joints, weights) = (halves(JOINTS)?, halves(WEIGHTS)?);
        let number = |le: &[u8; 2]| u16::from_le_bytes(*le);
        let pair = move |(joint, weight): (&[u8; 2], &[u8; 2])| {
            (usize::from(number(joint)), f32::from(number(weight)) / f32::from(u16::MAX))
        };
        Some(joints.iter().zip(weights).map(pair))
    }

    pub(super) fn lbs_joints(&self) -> &'a [[u8; 2]] {
        self.halves(JOINTS)
    }

    pub(super) fn names(&self) -> Names<'a> {
        Names::new(self.0.bytes(NAMES), 1)
    }

    fn halves(&self, place: usize) -> &'a [[u8; 2]] {
        self.0.bytes(place).as_chunks().0
    }
}
