//! Writes envelopes, the skins that follow them, priors and records as parts of a file. `bake/container.rs` joins the
//! parts.

mod envelope;
mod skin;

use crate::Error;
use crate::bake::sections::{floats, names, narrow, words};
use crate::bake::{Part, Sections, bake};
use crate::envelope::lbs::blend::Weights;
use crate::envelope::model::{FileModel, RecordModel};
use sinew_runtime::format::{Element, PartKind, SectionKind};
use sinew_runtime::record::RecordCounts;

impl FileModel {
    /// Bakes a file, then loads it once to check it. The parts are in order: envelopes, skins, priors, records.
    ///
    /// Weights are divided by their sum and rounded; all other numbers are only rounded.
    ///
    /// # Errors
    /// - Arrays differ in length.
    /// - An index or a size does not fit the file.
    /// - Joints do not form one tree, or a rest frame is singular.
    /// - A vertex has no positive sum of weights.
    /// - A prior's covariance has no inverse.
    /// - A skin follows an envelope that does not exist.
    /// - The runtime refuses the file for another reason, for example a number that is not finite.
    pub fn bake(&self) -> Result<Vec<u8>, Error> {
        let mut parts = Vec::new();
        for envelope in &self.envelopes {
            parts.push(envelope.part()?);
        }
        let found = self.envelopes.len();
        for (skin, model) in self.skins.iter().enumerate() {
            let followed = |envelope| {
                let missing = || {
                    Error::missing(format!("skin {skin} follows envelope {envelope}, of {found}"))
                };
                self.envelopes.get(envelope).ok_or_else(missing)
            };
            parts.push(model.part(model.envelope.map(followed).transpose()?)?);
        }
        for prior in &self.priors {
            parts.push(prior.part(found + prior.skin)?);
        }
        for record in &self.records {
            parts.push(record.part()?);
        }
        bake(self.space, &parts)
    }
}

impl RecordModel {
    /// Writes the record as a part.
    ///
    /// # Errors
    /// An index or a size does not fit the file.
    pub(crate) fn part(&self) -> Result<Part, Error> {
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

/// Writes the joints (u16) and the weights (in units of 1/65,535, u16) of all vertices.
fn influences(lbs: &Weights) -> Result<(Vec<u8>, Vec<u8>), Error> {
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
