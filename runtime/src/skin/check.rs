//! The checks of a skin, in the order that FORMAT.md lists.

use super::bounds::Bounds;
use super::counts::{LENGTH_TOLERANCE, NO_ENVELOPE, RULES, SkinCounts, WEIGHT_SUM_TOLERANCE};
use super::view::{Skin, SkinLayout};
use crate::format::content::{check_count, check_floats, check_index, invalid};
use crate::format::{FileError, FileErrorKind as Kind, Manifest, SectionKind};
use crate::limits::Limits;
use crate::linear::{dot, floats};

/// Finds a part's counts and arrays, after checking its counts and its sections' lengths.
///
/// - `palette_len`: counts the palette of a part, if that is an envelope.
pub(crate) fn layout(
    manifest: &Manifest,
    file: &[u8],
    part: u16,
    limits: &Limits,
    palette_len: impl Fn(u16) -> Option<usize>,
) -> Result<SkinLayout, FileError> {
    manifest.check_known(file, part, &RULES)?;
    let (section, mut words) = (SectionKind::SkinCounts, [0; 4]);
    manifest.counts(file, part, section, &mut words)?;
    let counts = SkinCounts::from_words(words);
    // More influences than indices can tell apart have no transforms to be of.
    let most = limits.influences.min(u16::MAX.into());
    let influences = if counts.envelope == NO_ENVELOPE { 0..=0 } else { 1..=most };
    check_count(section, 0, 0..=limits.vertices, counts.vertex_len)?;
    check_count(section, 1, influences, counts.influence_len)?;
    let palette_len = match counts.envelope {
        NO_ENVELOPE => Some(0),
        _ => counts.envelope().and_then(palette_len),
    };
    let Some(palette_len) = palette_len else {
        let values = [manifest.parts(file).len() as u32, counts.envelope];
        return Err(FileError::of(Kind::Index, section, 2, values));
    };
    // A palette has at most twice 65,535 transforms.
    let palette_len = palette_len as u32;
    let mut layout = SkinLayout::new(manifest.id(), part, counts, palette_len);
    let asked = (counts.bits(), &counts.sizes(palette_len)[..]);
    manifest.find_all((file, part), &RULES, asked, layout.spans_mut())?;
    Ok(layout)
}

/// Checks the content of a skin whose sections all have their length.
pub(crate) fn content(skin: &Skin<'_>) -> Result<(), FileError> {
    if let Some(index) = skin.names().unsound() {
        return invalid(SectionKind::Names, index);
    }
    check_floats(skin.file_bytes(), &RULES, skin.spans())?;
    check_directions(skin)?;
    check_ranges(skin)?;
    check_influences(skin)
}

/// Checks that normals have length 1 or 0, tangents length 1 and a handedness of 1 or -1.
fn check_directions(skin: &Skin<'_>) -> Result<(), FileError> {
    let is_unit = |v: [f32; 3]| (dot(v, v) - 1.0).abs() <= LENGTH_TOLERANCE;
    let fits = |n: [f32; 3]| is_unit(n) || n == [0.0; 3];
    let unfit = skin.normals().iter().position(|n| !fits(floats(n)));
    if let Some(vertex) = unfit {
        return invalid(SectionKind::RestNormals, vertex);
    }
    let fits = |[x, y, z, hand]: [f32; 4]| is_unit([x, y, z]) && hand.abs() == 1.0;
    let unfit = skin.tangents().iter().position(|t| !fits(floats(t)));
    if let Some(vertex) = unfit {
        return invalid(SectionKind::RestTangents, vertex);
    }
    Ok(())
}

/// Checks that ranges lie inside the mesh, one after the other.
fn check_ranges(skin: &Skin<'_>) -> Result<(), FileError> {
    let mut last = 0;
    for (index, row) in skin.range_rows().iter().enumerate() {
        let [start, end] = row.map(u32::from_le_bytes);
        if start < last || end < start || end as usize > skin.vertex_len() {
            return invalid(SectionKind::Ranges, index);
        }
        last = end;
    }
    Ok(())
}

/// Checks that influences point into the palette, sum to one, and stay in their transforms' boxes.
fn check_influences(skin: &Skin<'_>) -> Result<(), FileError> {
    // Without an envelope there are none; chunks of zero would panic.
    let (below, k) = (skin.palette_len(), skin.influence_len().max(1));
    let boxes = skin.boxes();
    let influences = skin.indices().chunks_exact(k).zip(skin.weights().chunks_exact(k));
    let vertices = skin.positions().iter().map(floats).zip(influences).enumerate();
    for (vertex, (position, (indices, weights))) in vertices {
        let mut sum = 0.0;
        for ((index, weight), at) in indices.iter().zip(weights).zip(vertex * k..) {
            let found = usize::from(u16::from_le_bytes(*index));
            check_index(SectionKind::InfluenceIndices, at, below, found)?;
            let weight = f32::from_le_bytes(*weight);
            sum += weight;
            let inside = boxes.get(found).and_then(Bounds::from_corners);
            if weight > 0.0 && !inside.is_some_and(|rest| rest.contains(position)) {
                let values = [0, vertex as u32];
                return Err(FileError::of(Kind::Invalid, SectionKind::RestBoxes, found, values));
            }
        }
        if (sum - 1.0).abs() > WEIGHT_SUM_TOLERANCE {
            return invalid(SectionKind::InfluenceWeights, vertex);
        }
    }
    Ok(())
}
