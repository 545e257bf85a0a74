//! Records as plain lists, whose fields may be invalid.

use crate::bytes::{floats, names, words};
use crate::message::head;
use crate::pieces::{Content, Pieces};
use sinew_runtime::format::{PartKind, PartRow, SectionKind};
use sinew_runtime::record::RECORD_SECTIONS;

/// A record as plain lists.
#[derive(Clone)]
pub struct RecordContent {
    /// Name of the part: the name of its envelope.
    pub name: String,
    /// Number of joints J.
    pub joint_len: u32,
    /// 4 F marks of F frames.
    pub marks: Vec<f32>,
    /// K, V K joints, and V K weights in units of 1/65,535, if the file has them.
    pub lbs: Option<(u32, Vec<u16>, Vec<u16>)>,
}

impl RecordContent {
    /// Makes a record of three frames, and of two vertices on three joints.
    pub fn sample() -> Self {
        Self {
            name: "envelope".to_owned(),
            joint_len: 3,
            marks: (0..12).map(|at| 0.125 * at as f32).collect(),
            lbs: Some((2, vec![0, 2, 1, 0], vec![65_535, 0, 40_000, 25_535])),
        }
    }

    /// Writes the sections.
    ///
    /// # Panics
    /// If the order of sections differs from FORMAT.md.
    fn sections(&self) -> Vec<(SectionKind, Vec<u8>)> {
        let frames = self.marks.len() as u32 / 4;
        let (most, joints, weights) = self.lbs.clone().unwrap_or_default();
        let vertices = joints.len() as u32 / most.max(1);
        let halves = |all: &[u16]| all.iter().flat_map(|half| half.to_le_bytes()).collect();
        let counts = words(&[frames, vertices, most, self.joint_len]);
        let mut written = vec![
            (SectionKind::RecordCounts, counts),
            (SectionKind::Names, names(&self.name, &[])),
            (SectionKind::FrameMarks, floats(&self.marks)),
        ];
        if self.lbs.is_some() {
            written.push((SectionKind::LbsJoints, halves(&joints)));
            written.push((SectionKind::LbsWeights, halves(&weights)));
        }
        let mut order = RECORD_SECTIONS.iter();
        assert!(written.iter().all(|(kind, _)| order.any(|own| own == kind)));
        written
    }
}

impl Pieces {
    /// Makes a file of one record.
    ///
    /// # Panics
    /// If the order of sections differs from FORMAT.md.
    pub fn record(content: &RecordContent) -> Self {
        let mut pieces = Self { head: head::SOUND, parts: Vec::new(), sections: Vec::new() };
        pieces.add_record(content);
        pieces
    }

    /// Appends a record, which readers may ignore.
    ///
    /// # Panics
    /// If the order of sections differs from FORMAT.md.
    pub fn add_record(&mut self, content: &RecordContent) {
        let part = self.parts.len() as u16;
        self.parts.push(PartRow { kind: PartKind::Record.number(), flags: 0 });
        let own = content.sections().into_iter();
        self.sections.extend(own.map(|(kind, bytes)| Content::new(kind, part, bytes)));
    }
}
