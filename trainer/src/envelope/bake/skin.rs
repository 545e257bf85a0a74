//! How a file holds a skin.

use super::shapes;
use crate::bake::sections::{check_len, floats, halves, names, narrow, words};
use crate::bake::{BakeError, Part};
use crate::envelope::model::{EnvelopeModel, SkinModel};
use sinew_runtime::format::{PartKind, SectionKind};
use sinew_runtime::skin::{NO_ENVELOPE, SKIN_SECTIONS, SkinCounts};

/// The sections of shapes.
const OF_SHAPES: [SectionKind; 6] = [
    SectionKind::Shapes,
    SectionKind::ShapeBlocks,
    SectionKind::ShapeEntries,
    SectionKind::ShapeDeltas,
    SectionKind::ShapeSlopes,
    SectionKind::ShapeErrors,
];

impl SkinModel {
    /// Writes the part.
    ///
    /// - `envelope`: the one that it follows; it is the part of the number that [`Self::envelope`] has.
    pub(super) fn part(&self, envelope: Option<&EnvelopeModel>) -> Result<Part, BakeError> {
        let v = self.rest_positions.len();
        check_len("rest normals", v, self.rest_normals.len())?;
        check_len("rest tangents", v, self.rest_tangents.as_ref().map_or(v, Vec::len))?;
        check_len("influences", envelope.map_or(0, |_| v), self.influences.len())?;
        let shapes = shapes::write(&self.shapes, v)?;
        let k = self.influence_len().max(usize::from(envelope.is_some()));
        let counts = SkinCounts {
            vertex_len: narrow("vertices", v)?,
            influence_len: narrow("influences", k)?,
            envelope: self.envelope.map_or(Ok(NO_ENVELOPE), |number| narrow("envelope", number))?,
            range_len: narrow("ranges", self.ranges.len())?,
            shape_len: narrow("shapes", self.shapes.len())?,
            entry_len: narrow("entries of shapes", shapes.entry_len())?,
            delta_len: narrow("deltas of shapes", shapes.delta_len)?,
        };
        let rounded: Vec<_> = self.rest_positions.iter().map(|x| x.map(|x| x as f32)).collect();
        let mut ranges = Vec::new();
        for (_, range) in &self.ranges {
            ranges.extend([narrow::<u32>("vertex", range.start)?, narrow("vertex", range.end)?]);
        }
        let range_names = self.ranges.iter().map(|(name, _)| name);
        let all_names = [&self.name].into_iter().chain(range_names).chain(&self.shapes.names);
        let palette_len = envelope.map_or(0, EnvelopeModel::palette_len);
        let contents = [
            (SectionKind::SkinCounts, Some(words(&counts.words()))),
            (SectionKind::Names, Some(names(all_names)?)),
            (SectionKind::RestPositions, Some(floats(self.rest_positions.as_flattened()))),
            (SectionKind::RestNormals, Some(floats(self.rest_normals.as_flattened()))),
            (
                SectionKind::RestTangents,
                self.rest_tangents.as_ref().map(|t| floats(t.as_flattened())),
            ),
            (SectionKind::InfluenceIndices, Some(indices(self, k)?)),
            (SectionKind::InfluenceWeights, Some(weights(self, k)?)),
            (SectionKind::RestBoxes, Some(rest_boxes(self, &rounded, palette_len))),
            (SectionKind::Ranges, Some(words(&ranges))),
            (SectionKind::TangentCoefficients, coefficients(self, k)?),
            (
                SectionKind::NormalErrors,
                self.normal_errors.map(|errors| floats(&errors.figures().map(f64::from))),
            ),
            (SectionKind::Shapes, Some(shapes.rows)),
            (SectionKind::ShapeBlocks, Some(shapes.blocks)),
            (SectionKind::ShapeEntries, Some(shapes.entries)),
            (SectionKind::ShapeDeltas, Some(shapes.deltas)),
            (SectionKind::ShapeSlopes, Some(shapes.slopes)),
            (SectionKind::ShapeErrors, Some(shapes.errors)),
        ];
        debug_assert!(contents.iter().map(|(kind, _)| *kind).eq(SKIN_SECTIONS));
        let own = contents.into_iter().filter(|(kind, _)| counts.has(*kind) != Some(false));
        // A reader may leave shapes alone, as it may what a skin need not have.
        let required = |kind| counts.has(kind) == Some(true) && !OF_SHAPES.contains(&kind);
        let own = own.filter_map(|(kind, content)| Some((kind, required(kind), content?)));
        Ok(Part {
            kind: PartKind::Skin,
            sections: own.collect(),
            element: self.shapes.numbers.element(),
        })
    }
}

/// Writes K palette indices a vertex; those that are not used point to transform 0.
fn indices(skin: &SkinModel, k: usize) -> Result<Vec<u8>, BakeError> {
    let mut out = Vec::new();
    for influences in &skin.influences {
        for slot in 0..k {
            let index = influences.get(slot).map_or(0, |&(index, _)| index);
            out.extend(narrow::<u16>("palette index", index)?.to_le_bytes());
        }
    }
    Ok(out)
}

/// Writes K weights a vertex, those that are not used as 0.
fn weights(skin: &SkinModel, k: usize) -> Result<Vec<u8>, BakeError> {
    let mut out = Vec::new();
    for (vertex, influences) in skin.influences.iter().enumerate() {
        let sum = influences.iter().map(|&(_, weight)| weight).sum::<f64>();
        if !(sum > 0.0 && sum.is_finite()) {
            return Err(BakeError::Weights { vertex, sum });
        }
        let normalised = influences.iter().map(|&(_, weight)| weight / sum);
        out.extend(floats(&normalised.chain(std::iter::repeat(0.0)).take(k).collect::<Vec<_>>()));
    }
    Ok(out)
}

/// Writes g, h of a vertex's first K - 1 influences; `None` without coefficients.
fn coefficients(skin: &SkinModel, k: usize) -> Result<Option<Vec<u8>>, BakeError> {
    let Some(all) = &skin.tangent_coefficients else { return Ok(None) };
    check_len("vertices with tangent coefficients", skin.rest_positions.len(), all.len())?;
    let mut out = Vec::new();
    for coefficients in all {
        check_len("tangent coefficients of a vertex", k, coefficients.len())?;
        out.extend(halves(coefficients.iter().take(k.saturating_sub(1)).flatten().copied()));
    }
    Ok(Some(out))
}

/// Computes the box of the rounded rest positions that each transform of the palette moves; min > max if
/// it moves none.
fn rest_boxes(skin: &SkinModel, rest_positions: &[[f32; 3]], palette_len: usize) -> Vec<u8> {
    let mut boxes = vec![None::<([f32; 3], [f32; 3])>; palette_len];
    for (influences, &x) in skin.influences.iter().zip(rest_positions) {
        for &(index, weight) in influences {
            let Some(rest_box) = boxes.get_mut(index).filter(|_| weight > 0.0) else { continue };
            let (min, max) = rest_box.unwrap_or((x, x));
            let union = |i: usize| (min[i].min(x[i]), max[i].max(x[i]));
            let [x, y, z] = [0, 1, 2].map(union);
            *rest_box = Some(([x.0, y.0, z.0], [x.1, y.1, z.1]));
        }
    }
    let corners = boxes.into_iter().map(|rest_box| rest_box.unwrap_or(([1.0; 3], [-1.0; 3])));
    corners.flat_map(|(min, max)| min.into_iter().chain(max)).flat_map(f32::to_le_bytes).collect()
}
