//! Checks of a skin, in the order of FORMAT.md.

use super::bounds::is_inside;
use super::counts::{
    EIGHT, LENGTH_TOLERANCE, NO_ENVELOPE, RULES, SkinCounts, WEIGHT_SUM_TOLERANCE, place,
};
#[cfg(feature = "shapes")]
use super::shapes;
use super::view::{Row, Skin, float, rows_of};
use crate::format::content::{check_counts, check_floats, check_names};
use crate::format::part::{Asked, COUNTS, first_counts};
use crate::format::refusal::{Checked, Loading};
use crate::format::{Element, FileErrorKind as Kind, SectionKind};
use crate::linear::dot;

/// Checks the counts of a skin, and returns the flags and sizes for the rules of its sections.
///
/// - `words`: the counts. This function adds the length of the palette, and the element type of the shapes.
/// - `part_len`: number of parts in the file.
/// - `palette_len`: returns the palette length of a part; `None` if the part is not an envelope.
/// - `element`: returns the element type of a section of this part; `None` if the section is missing.
pub(crate) fn counts(
    words: &mut [u32; COUNTS],
    loading: &Loading<'_>,
    part_len: usize,
    palette_len: impl Fn(u16) -> Option<u32>,
    element: impl Fn(SectionKind) -> Option<Element>,
) -> Checked<Asked> {
    let section = SectionKind::SkinCounts;
    let counts = SkinCounts::from_words(first_counts(words));
    // Indices are u16, so a vertex cannot have more distinct influences.
    let most = loading.limits.influences.min(u16::MAX.into());
    let (least, most) = if counts.envelope == NO_ENVELOPE { (0, 0) } else { (1, most) };
    let ranges = [
        (place::VERTICES, 0, loading.limits.vertices),
        (place::INFLUENCES, least, most),
        (place::SHAPES, 0, loading.limits.shapes.min(u16::MAX.into())),
    ];
    check_counts(loading, section, words, &ranges)?;
    #[cfg(feature = "shapes")]
    let element = shapes::check::counts(words, loading, element)?;
    #[cfg(not(feature = "shapes"))]
    let element = {
        let _ = element;
        Element::F32
    };
    let palette_len = match counts.envelope {
        NO_ENVELOPE => Some(0),
        _ => counts.envelope().and_then(palette_len),
    };
    let Some(palette_len) = palette_len else {
        let values = [part_len as u32, counts.envelope];
        return Err(loading.refuse(Kind::Index, Some(section), place::ENVELOPE, values));
    };
    words[place::PALETTE] = palette_len;
    Ok(counts.asked(palette_len, element))
}

/// Checks the content of a skin whose sections have the right lengths.
pub(crate) fn content(skin: &Skin<'_>, loading: &Loading<'_>) -> Checked {
    CHECKS.iter().try_for_each(|check| check(skin, loading))
}

/// Checks of the content, in order. Calls through pointers are not inlined, so the checks share stack space.
static CHECKS: [fn(&Skin<'_>, &Loading<'_>) -> Checked;
    6 + cfg!(feature = "normals") as usize + cfg!(feature = "shapes") as usize] = [
    |skin, loading| check_names(loading, skin.names()),
    |skin, loading| check_floats(loading, &skin.0, &RULES),
    |skin, loading| {
        check_directions(loading, SectionKind::RestNormals, skin.normals().as_flattened(), 3)
    },
    |skin, loading| {
        check_directions(loading, SectionKind::RestTangents, skin.tangents().as_flattened(), 4)
    },
    check_ranges,
    check_influences,
    #[cfg(feature = "normals")]
    check_coefficients,
    #[cfg(feature = "shapes")]
    shapes::check::content,
];

/// Checks the lengths of directions. Normals have length 1 or 0; tangents have length 1, and a handedness of 1 or -1.
///
/// - `len`: floats of a direction, 3 for normals or 4 for tangents.
fn check_directions(
    loading: &Loading<'_>,
    section: SectionKind,
    rows: &[Row],
    len: usize,
) -> Checked {
    let mut vertex = 0;
    while let Some([x, y, z, hand @ ..]) = rows_of(rows, len, vertex) {
        let (x, y, z) = (float(x, vertex), float(y, vertex), float(z, vertex));
        let is_unit = (dot([x, y, z], [x, y, z]) - 1.0).abs() <= LENGTH_TOLERANCE;
        let fits = match hand.first() {
            // 0 or -0.
            None => is_unit || (x.to_bits() | y.to_bits() | z.to_bits()) << 1 == 0,
            Some(hand) => is_unit && float(hand, vertex).abs() == 1.0,
        };
        if !fits {
            return loading.invalid(section, vertex);
        }
        vertex += 1;
    }
    Ok(())
}

/// Checks that ranges are inside the mesh, in ascending order, and do not overlap.
fn check_ranges(skin: &Skin<'_>, loading: &Loading<'_>) -> Checked {
    let mut last = 0;
    for (index, row) in skin.range_rows().iter().enumerate() {
        let [start, end] = row.map(u32::from_le_bytes);
        if start < last || end < start || end as usize > skin.vertex_len() {
            return loading.invalid(SectionKind::Ranges, index);
        }
        last = end;
    }
    Ok(())
}

/// Checks that influences refer to the palette, that weights sum to 1, and that vertices are in the boxes of their
/// transforms.
fn check_influences(skin: &Skin<'_>, loading: &Loading<'_>) -> Checked {
    // Without an envelope K is 0, and there are no influences.
    let (boxes, positions, k) = (skin.boxes(), skin.positions(), skin.influence_len().max(1));
    let influences = skin.indices().as_flattened().iter().zip(skin.weights().as_flattened());
    let mut sums = [0.0; EIGHT];
    for (at, (index, weight)) in influences.enumerate() {
        let (row, lane) = (at / EIGHT, at % EIGHT);
        let Some([x, y, z]) = positions.get(row / k) else { return Ok(()) };
        let (position, vertex) =
            ([float(x, lane), float(y, lane), float(z, lane)], row / k * EIGHT + lane);
        let (found, weight) = (u16::from_le_bytes(*index), f32::from_le_bytes(*weight));
        let (kind, section, at, values) = match boxes.get(usize::from(found)) {
            None => {
                let values = [boxes.len() as u32, found.into()];
                (Kind::Index, SectionKind::InfluenceIndices, at, values)
            }
            Some(rest) if weight > 0.0 && !is_inside(rest, position) => {
                (Kind::Invalid, SectionKind::RestBoxes, found.into(), [0, vertex as u32])
            }
            Some(_) => {
                let sum = &mut sums[lane];
                *sum += weight;
                if (row + 1) % k > 0 {
                    continue;
                }
                if (*sum - 1.0).abs() <= WEIGHT_SUM_TOLERANCE {
                    *sum = 0.0;
                    continue;
                }
                (Kind::Invalid, SectionKind::InfluenceWeights, vertex, [0; 2])
            }
        };
        return Err(loading.refuse(kind, Some(section), at, values));
    }
    Ok(())
}

/// Checks that each tangent coefficient is 0 or a normal number.
#[cfg(feature = "normals")]
fn check_coefficients(skin: &Skin<'_>, loading: &Loading<'_>) -> Checked {
    let is_sound = |bits: u16| matches!((bits & 0x7c00, bits & 0x3ff), (0, 0) | (0x400..0x7c00, _));
    let halves = skin.coefficients().as_flattened().as_flattened().as_chunks().0;
    match halves.iter().position(|le| !is_sound(u16::from_le_bytes(*le))) {
        None => Ok(()),
        Some(at) => {
            let section = Some(SectionKind::TangentCoefficients);
            Err(loading.refuse(Kind::Float, section, at, [0; 2]))
        }
    }
}
