//! A record as a part of a file.

use crate::bake::sections::{floats, names, narrow, words};
use crate::bake::{BakeError, Part, Sections};
use crate::envelope::lbs::blend::Weights;
use crate::envelope::model::RecordModel;
use sinew_runtime::format::{Element, PartKind, SectionKind};
use sinew_runtime::record::RecordCounts;

impl RecordModel {
    /// Writes the part.
    ///
    /// # Errors
    /// [`BakeError::Size`].
    pub(crate) fn part(&self) -> Result<Part, BakeError> {
        let [vertices, most] = self.lbs.as_ref().map_or([0; 2], |lbs| [lbs.len(), lbs.most()]);
        let counts = RecordCounts {
            frame_len: narrow("training frames", self.marks.len())?,
            vertex_len: narrow("vertices", vertices)?,
            influence_len: narrow("influences", most)?,
            joint_len: narrow("joints", self.joint_len)?,
        };
        let marks: Vec<f64> = self.marks.iter().flatten().copied().map(f64::from).collect();
        let mut sections: Sections = vec![
            (SectionKind::RecordCounts, false, words(&counts.words())),
            (SectionKind::Names, false, names(std::iter::once(&self.envelope))?),
            (SectionKind::FrameMarks, false, floats(&marks)),
        ];
        if let Some(lbs) = &self.lbs {
            let (joints, weights) = influences(lbs)?;
            sections.push((SectionKind::LbsJoints, false, joints));
            sections.push((SectionKind::LbsWeights, false, weights));
        }
        Ok(Part { kind: PartKind::Record, sections, element: Element::U16 })
    }
}

/// Writes joints and weights of all vertices, the latter in 65,535ths.
fn influences(lbs: &Weights) -> Result<(Vec<u8>, Vec<u8>), BakeError> {
    let (mut joints, mut weights) = (Vec::new(), Vec::new());
    for vertex in 0..lbs.len() {
        let all = lbs.of(vertex).chain(std::iter::repeat((0, 0.0)));
        for (joint, weight) in all.take(lbs.most()) {
            joints.extend(narrow::<u16>("joints", joint)?.to_le_bytes());
            let share = (weight * f64::from(u16::MAX)).round() as u16;
            weights.extend(share.to_le_bytes());
        }
    }
    Ok((joints, weights))
}
