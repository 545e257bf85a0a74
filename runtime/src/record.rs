//! The part record: an envelope's training data in short. A later measurement needs to know the
//! training frames, and the error of linear blend skinning on the examples. Evaluation does not use
//! the record.

use crate::format::SectionKind;
use crate::format::content;
use crate::format::flat::flat;
use crate::format::part::{self, Asked, COUNTS, Part, SECTIONS, first_counts};
use crate::format::refusal::{Checked, Loading};
use crate::format::rule::{ALWAYS, Rule};
use crate::linear::floats;
use crate::names::Names;

const NAMES: usize = Rule::place(&RULES, SectionKind::Names);
const MARKS: usize = Rule::place(&RULES, SectionKind::FrameMarks);
const JOINTS: usize = Rule::place(&RULES, SectionKind::LbsJoints);
const WEIGHTS: usize = Rule::place(&RULES, SectionKind::LbsWeights);

/// Training data of the envelope with the record's name; borrowed from a loaded model.
///
/// Accessors by number return `None` if the number is out of range.
#[derive(Clone, Copy)]
pub struct Record<'a>(pub(crate) Part<'a>);

part::view! { Record, Record, |words| -> RecordCounts { RecordCounts::from_words(first_counts(words)) } }

impl<'a> Record<'a> {
    /// Lists the marks of the training frames: numbers that identify a frame in any axes and unit
    /// (METHOD §1.12).
    pub fn frame_marks(&self) -> impl ExactSizeIterator<Item = [f32; MARK_LEN]> + use<'a> {
        self.0.array(MARKS).iter().map(floats)
    }

    /// Lists the joints of a vertex in linear blend skinning, each with its weight. The weights
    /// were fitted to the training frames and sum to 1 up to rounding. A record without weights
    /// lists none.
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

    fn lbs_joints(&self) -> &'a [[u8; 2]] {
        self.halves(JOINTS)
    }

    fn names(&self) -> Names<'a> {
        Names::new(self.0.bytes(NAMES), 1)
    }

    fn halves(&self, place: usize) -> &'a [[u8; 2]] {
        self.0.bytes(place).as_chunks().0
    }
}

/// Numbers per mark of a frame.
pub const MARK_LEN: usize = 4;

/// Counts of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "internals", visibility::make(pub))]
pub(crate) struct RecordCounts {
    /// Training frames, F.
    pub frame_len: u32,
    /// Vertices of the examples, with one vertex per point of the surface, V.
    pub vertex_len: u32,
    /// Joints per vertex in linear blend skinning, K; 0 if the file has no such weights.
    pub influence_len: u32,
    /// Joints of the envelope, J.
    pub joint_len: u32,
}

flat! { RecordCounts of "record_counts", words, from_words: [u32; 4] {
    frame_len, vertex_len, influence_len, joint_len
} }

impl RecordCounts {
    /// Computes a section's length in bytes, or the least length of the names; `None` if records
    /// lack the section.
    pub fn section_bytes(&self, section: SectionKind) -> Option<u64> {
        Rule::of(&RULES, section)?.bytes(&self.asked().sizes)
    }

    /// Returns the requirements for the sections, in the terms of [`RULES`].
    const fn asked(&self) -> Asked {
        let skins = if self.influence_len > 0 { SKINS } else { 0 };
        Asked::new(ALWAYS | skins, [1, self.frame_len, self.vertex_len, self.influence_len])
    }
}

/// Indices of the counts in their section.
mod place {
    pub(super) const VERTICES: usize = 1;
    pub(super) const INFLUENCES: usize = 2;
    pub(super) const JOINTS: usize = 3;
}

/// Bit for a record with weights of linear blend skinning.
const SKINS: u8 = 4;

/// The sections of a record, in the trainer's order.
#[cfg_attr(feature = "internals", visibility::make(pub))]
pub(crate) const RECORD_SECTIONS: [SectionKind; RULES.len()] = Rule::sections(&RULES);

const _: () = assert!(RULES.len() <= SECTIONS && RecordCounts::BYTES <= 4 * COUNTS);

/// Rules for the sections of a record. Sizes: 1, F, V, K.
pub(crate) const RULES: [Rule; 5] = [
    Rule::new(SectionKind::RecordCounts, RecordCounts::BYTES as u8, [0, 0]),
    Rule::new(SectionKind::Names, 4, [0, 0]).or_more(0),
    Rule::floats(SectionKind::FrameMarks, 4 * MARK_LEN as u8, [1, 0]).unsigned(),
    Rule::new(SectionKind::LbsJoints, 2, [2, 3]).with(SKINS),
    Rule::new(SectionKind::LbsWeights, 2, [2, 3]).with(SKINS),
];

/// Checks a record's counts, and returns the requirements for its sections.
pub(crate) fn check_counts(words: &[u32; COUNTS], loading: &Loading<'_>) -> Checked<Asked> {
    let most = u32::from(u16::MAX);
    let ranges = [
        (place::VERTICES, 0, loading.limits.vertices),
        (place::INFLUENCES, 0, loading.limits.influences.min(most)),
        (place::JOINTS, 1, loading.limits.joints.min(most)),
    ];
    content::check_counts(loading, SectionKind::RecordCounts, words, &ranges)?;
    Ok(RecordCounts::from_words(first_counts(words)).asked())
}

/// Checks the content of a record. The lengths of all sections have been checked before.
pub(crate) fn check_content(record: &Record<'_>, loading: &Loading<'_>) -> Checked {
    content::check_names(loading, record.names())?;
    content::check_floats(loading, &record.0, &RULES)?;
    let below = record.counts().joint_len;
    for (index, joint) in record.lbs_joints().iter().enumerate() {
        let found = u16::from_le_bytes(*joint).into();
        content::check_index(loading, SectionKind::LbsJoints, index, below, found)?;
    }
    Ok(())
}
