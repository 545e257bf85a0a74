//! The numbers of a record, from which every section's length follows.

use crate::format::SectionKind;
use crate::format::part::{Asked, COUNTS, SECTIONS};
use crate::format::rule::{ALWAYS, Rule};

/// Numbers of a frame's mark.
pub const MARK_LEN: usize = 4;

/// Counts of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordCounts {
    /// Training frames, F.
    pub frame_len: u32,
    /// Vertices of the examples, one a point of the surface, V.
    pub vertex_len: u32,
    /// Joints that a vertex follows in linear blend skinning, K; 0 if the file has no weights for it.
    pub influence_len: u32,
    /// Joints of the envelope, J.
    pub joint_len: u32,
}

impl RecordCounts {
    /// Bytes of section `record_counts`.
    pub const BYTES: usize = 16;

    /// Lists the counts in the order of the file.
    pub const fn words(&self) -> [u32; 4] {
        let Self { frame_len, vertex_len, influence_len, joint_len } = *self;
        [frame_len, vertex_len, influence_len, joint_len]
    }

    /// Makes them of their words.
    pub const fn from_words([frame_len, vertex_len, influence_len, joint_len]: [u32; 4]) -> Self {
        Self { frame_len, vertex_len, influence_len, joint_len }
    }

    /// Computes a section's length in bytes, the least of the names; `None` if no record has it.
    pub fn section_bytes(&self, section: SectionKind) -> Option<u64> {
        Rule::of(&RULES, section)?.bytes(&self.asked().sizes)
    }

    /// Returns what they ask of the sections, as [`RULES`] have it.
    pub(crate) const fn asked(&self) -> Asked {
        let skins = if self.influence_len > 0 { SKINS } else { 0 };
        Asked::new(ALWAYS | skins, [1, self.frame_len, self.vertex_len, self.influence_len])
    }
}

/// Where the counts stand in their section.
pub(crate) mod place {
    pub(crate) const VERTICES: usize = 1;
    pub(crate) const INFLUENCES: usize = 2;
    pub(crate) const JOINTS: usize = 3;
}

/// Bit of a record with weights of linear blend skinning.
const SKINS: u8 = 4;

/// The sections of a record, in the order in which the trainer writes them.
pub const RECORD_SECTIONS: [SectionKind; RULES.len()] = Rule::sections(&RULES);

const _: () = assert!(RULES.len() <= SECTIONS && RecordCounts::BYTES <= 4 * COUNTS);

/// What a record asks of its sections. Sizes: 1, F, V, K.
pub(crate) const RULES: [Rule; 5] = [
    Rule::new(SectionKind::RecordCounts, RecordCounts::BYTES as u8, [0, 0]),
    Rule::new(SectionKind::Names, 4, [0, 0]).or_more(0),
    Rule::floats(SectionKind::FrameMarks, 4 * MARK_LEN as u8, [1, 0]).unsigned(),
    Rule::new(SectionKind::LbsJoints, 2, [2, 3]).with(SKINS),
    Rule::new(SectionKind::LbsWeights, 2, [2, 3]).with(SKINS),
];
