//! From a checked section table to the arrays of an envelope.

use super::{Envelope, Names};
use crate::error::FormatError;
use crate::format::{Manifest, PartRow, Predictor, Presence, SectionKind};

impl<'a> Envelope<'a> {
    /// Finds the sections of a part and cuts them into arrays; reads none of their content.
    ///
    /// # Errors
    /// - [`FormatError::Predictor`]
    /// - [`FormatError::UnexpectedSection`]
    /// - [`FormatError::MissingSection`]
    /// - [`FormatError::SectionLength`]
    pub(crate) fn view(
        manifest: &Manifest<'a>,
        part: usize,
        row: PartRow,
    ) -> Result<Self, FormatError> {
        let predictor = Predictor::from_number(row.predictor)
            .ok_or(FormatError::Predictor { found: row.predictor })?;
        let counts = row.envelope_counts();
        let find = |section: SectionKind| {
            let found = manifest.find(part, section);
            match (section.presence(predictor), found) {
                (Presence::Required, None) => Err(FormatError::MissingSection { section }),
                (Presence::Absent, Some(_)) => Err(FormatError::UnexpectedSection { section }),
                (_, None) => Ok(None),
                (_, Some(bytes)) => {
                    section.check_len(predictor, &counts, bytes.len()).map(|()| Some(bytes))
                }
            }
        };
        let bytes = |section| find(section).map(Option::unwrap_or_default);
        let words = |section| bytes(section).map(|bytes| bytes.as_chunks::<4>().0);
        let halves = |section| bytes(section).map(|bytes| bytes.as_chunks::<2>().0);

        let joint_len = counts.joint_len as usize;
        let names = bytes(SectionKind::Names)?;
        let (ends, text) = names.split_at_checked(4 * (joint_len + 1)).unwrap_or_default();
        let hierarchy = halves(SectionKind::Hierarchy)?;
        let (parents, order_ranks) = hierarchy.split_at_checked(joint_len).unwrap_or_default();
        let (order, ranks) = order_ranks.split_at_checked(joint_len).unwrap_or_default();
        Ok(Self {
            part,
            predictor,
            counts,
            certificate: row.certificate(),
            names: Names { ends: ends.as_chunks().0, text },
            parents,
            order,
            ranks,
            inverse_binds: words(SectionKind::InverseBinds)?.as_chunks().0,
            positions: words(SectionKind::RestPositions)?.as_chunks().0,
            normals: words(SectionKind::RestNormals)?.as_chunks().0,
            tangents: find(SectionKind::RestTangents)?
                .map(|bytes| bytes.as_chunks::<4>().0.as_chunks().0),
            indices: halves(SectionKind::InfluenceIndices)?,
            weights: words(SectionKind::InfluenceWeights)?,
            keys: words(SectionKind::Keys)?.as_chunks().0,
            c1: words(SectionKind::C1)?.as_chunks().0,
            c2: words(SectionKind::C2)?.as_chunks().0,
            boxes: words(SectionKind::RestBoxes)?.as_chunks().0,
            pose_ranges: words(SectionKind::PoseRanges)?,
            origins: words(SectionKind::Origins)?.as_chunks().0,
            groups: bytes(SectionKind::Groups)?.as_chunks().0,
            corrections: bytes(SectionKind::Corrections)?,
        })
    }
}
