//! From a checked section table to the arrays of an envelope.

use super::{Envelope, Names};
use crate::error::FormatError;
use crate::format::{Manifest, PartRow, Predictor, Presence, SectionKind};

impl<'a> Envelope<'a> {
    /// Checks that a part has the sections of its predictor, each of the length that its counts
    /// give; reads none of their content.
    ///
    /// # Errors
    /// - [`FormatError::Predictor`]
    /// - [`FormatError::UnexpectedSection`]
    /// - [`FormatError::MissingSection`]
    /// - [`FormatError::SectionLength`]
    pub(crate) fn check_sections(
        manifest: &Manifest<'a>,
        part: usize,
        row: &PartRow,
    ) -> Result<(), FormatError> {
        let predictor = Predictor::from_number(row.predictor)
            .ok_or(FormatError::Predictor { found: row.predictor })?;
        let counts = row.envelope_counts();
        for section in SectionKind::ALL {
            match (section.presence(predictor), manifest.find(part, section)) {
                (Presence::Required, None) => return Err(FormatError::MissingSection { section }),
                (Presence::Absent, Some(_)) => {
                    return Err(FormatError::UnexpectedSection { section });
                }
                (_, None) => {}
                (_, Some(bytes)) => section.check_len(predictor, &counts, bytes.len())?,
            }
        }
        Ok(())
    }

    /// Cuts the sections of a part into arrays, after [`Envelope::check_sections`]; `None` where the
    /// part has no known predictor.
    pub(crate) fn view(manifest: &Manifest<'a>, part: usize, row: &PartRow) -> Option<Self> {
        let predictor = Predictor::from_number(row.predictor)?;
        let counts = row.envelope_counts();
        let bytes = SectionKind::ALL.map(|kind| manifest.find(part, kind).unwrap_or_default());
        // In the order of `SectionKind::ALL`.
        let [names, hierarchy, inverse_binds, positions, normals, tangents, bytes @ ..] = bytes;
        let [indices, weights, keys, c1, c2, boxes, ranges, origins, groups, corrections] = bytes;
        let words = |bytes: &'a [u8]| bytes.as_chunks::<4>().0;

        let joint_len = counts.joint_len as usize;
        let (ends, text) = names.split_at_checked(4 * (joint_len + 1)).unwrap_or_default();
        let hierarchy = hierarchy.as_chunks::<2>().0;
        let (parents, order_ranks) = hierarchy.split_at_checked(joint_len).unwrap_or_default();
        let (order, ranks) = order_ranks.split_at_checked(joint_len).unwrap_or_default();
        let has_tangents = manifest.find(part, SectionKind::RestTangents).is_some();
        Some(Self {
            part,
            predictor,
            counts,
            certificate: row.certificate(),
            names: Names { ends: words(ends), text },
            parents,
            order,
            ranks,
            inverse_binds: words(inverse_binds).as_chunks().0,
            positions: words(positions).as_chunks().0,
            normals: words(normals).as_chunks().0,
            tangents: has_tangents.then_some(words(tangents).as_chunks().0),
            indices: indices.as_chunks().0,
            weights: words(weights),
            keys: words(keys).as_chunks().0,
            c1: words(c1).as_chunks().0,
            c2: words(c2).as_chunks().0,
            boxes: words(boxes).as_chunks().0,
            pose_ranges: words(ranges),
            origins: words(origins).as_chunks().0,
            groups: groups.as_chunks().0,
            corrections,
        })
    }
}
