//! A skin's parts, and how a file holds them.

use super::envelope::EnvelopeParts;
use super::error::BakeError;
use super::sections::{Sections, check_len, floats, names, narrow, words};
use sinew_runtime::format::SectionKind;
use sinew_runtime::skin::{NO_ENVELOPE, SKIN_SECTIONS, SkinCounts};
use std::ops::Range;

/// Everything that a skin holds: a mesh, and how it follows a palette.
#[derive(Clone, Debug)]
pub struct SkinParts {
    /// Name of the part.
    pub name: String,
    /// Its envelope's number in [`super::ModelParts::envelopes`]; `None` for a mesh that follows none.
    pub envelope: Option<usize>,
    /// Rest positions, V.
    pub rest_positions: Vec<[f64; 3]>,
    /// Rest normals, V, of length 1 or 0.
    pub rest_normals: Vec<[f64; 3]>,
    /// Rest tangents of length 1 and, last, handedness, V.
    pub rest_tangents: Option<Vec<[f64; 4]>>,
    /// Influences of each vertex, V: palette index and weight. K is the longest list's length. Empty
    /// without an envelope.
    pub influences: Vec<Vec<(usize, f64)>>,
    /// The meshes that it was made of, by name: ranges of vertices, one after the other.
    pub ranges: Vec<(String, Range<usize>)>,
}

impl SkinParts {
    /// Writes its sections.
    ///
    /// - `envelope`: the one that it follows; it is the part of the number that [`Self::envelope`] has.
    pub(super) fn sections(&self, envelope: Option<&EnvelopeParts>) -> Result<Sections, BakeError> {
        let v = self.rest_positions.len();
        check_len("rest normals", v, self.rest_normals.len())?;
        check_len("rest tangents", v, self.rest_tangents.as_ref().map_or(v, Vec::len))?;
        check_len("influences", envelope.map_or(0, |_| v), self.influences.len())?;
        let k = self.influences.iter().map(Vec::len).max().unwrap_or(0);
        let k = k.max(usize::from(envelope.is_some()));
        let counts = SkinCounts {
            vertex_len: narrow("vertices", v)?,
            influence_len: narrow("influences", k)?,
            envelope: self.envelope.map_or(Ok(NO_ENVELOPE), |number| narrow("envelope", number))?,
            range_len: narrow("ranges", self.ranges.len())?,
        };
        let rounded: Vec<_> = self.rest_positions.iter().map(|x| x.map(|x| x as f32)).collect();
        let mut ranges = Vec::new();
        for (_, range) in &self.ranges {
            ranges.extend([narrow::<u32>("vertex", range.start)?, narrow("vertex", range.end)?]);
        }
        let all_names = [&self.name].into_iter().chain(self.ranges.iter().map(|(name, _)| name));
        let palette_len = envelope.map_or(0, EnvelopeParts::palette_len);
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
        ];
        debug_assert!(contents.iter().map(|(kind, _)| *kind).eq(SKIN_SECTIONS));
        let own = contents.into_iter().filter(|(kind, _)| counts.has(*kind) != Some(false));
        let own = own
            .filter_map(|(kind, content)| Some((kind, counts.has(kind) == Some(true), content?)));
        Ok(own.collect())
    }
}

/// Writes K palette indices a vertex; those that are not used point to transform 0.
fn indices(parts: &SkinParts, k: usize) -> Result<Vec<u8>, BakeError> {
    let mut out = Vec::new();
    for influences in &parts.influences {
        for slot in 0..k {
            let index = influences.get(slot).map_or(0, |&(index, _)| index);
            out.extend(narrow::<u16>("palette index", index)?.to_le_bytes());
        }
    }
    Ok(out)
}

/// Writes K weights a vertex, those that are not used as 0.
fn weights(parts: &SkinParts, k: usize) -> Result<Vec<u8>, BakeError> {
    let mut out = Vec::new();
    for (vertex, influences) in parts.influences.iter().enumerate() {
        let sum = influences.iter().map(|&(_, weight)| weight).sum::<f64>();
        if !(sum > 0.0 && sum.is_finite()) {
            return Err(BakeError::Weights { vertex, sum });
        }
        let normalised = influences.iter().map(|&(_, weight)| weight / sum);
        out.extend(floats(&normalised.chain(std::iter::repeat(0.0)).take(k).collect::<Vec<_>>()));
    }
    Ok(out)
}

/// Computes the box of the rounded rest positions that each transform of the palette moves; min > max if
/// it moves none.
fn rest_boxes(parts: &SkinParts, rest_positions: &[[f32; 3]], palette_len: usize) -> Vec<u8> {
    let mut boxes = vec![None::<([f32; 3], [f32; 3])>; palette_len];
    for (influences, &x) in parts.influences.iter().zip(rest_positions) {
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
