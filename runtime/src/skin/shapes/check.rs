//! Checks of shapes, in the order of FORMAT.md.

use super::super::bounds::is_inside;
use super::super::counts::{BLOCK, place};
use super::super::view::Skin;
use super::blocks::{Blocks, Entry, Numbers};
use crate::format::content::{check_counts, check_index, outside};
use crate::format::part::COUNTS;
use crate::format::refusal::{Checked, Loading};
use crate::format::{Element, FileErrorKind as Kind, MAGNITUDE_MAX, SectionKind};
use crate::linear::floats;

/// Checks the counts of shapes, and returns the element type of the deltas and slopes.
///
/// - `words`: the counts. This function adds the element type.
/// - `element`: returns the element type of a section of the part; `None` if the section is missing.
pub(crate) fn counts(
    words: &mut [u32; COUNTS],
    loading: &Loading<'_>,
    element: impl Fn(SectionKind) -> Option<Element>,
) -> Checked<Element> {
    let most = if words[place::SHAPES] == 0 { 0 } else { u32::MAX };
    let ranges = [(place::ENTRIES, 0, most), (place::DELTAS, 0, most)];
    check_counts(loading, SectionKind::SkinCounts, words, &ranges)?;
    let (deltas, slopes) = (element(SectionKind::ShapeDeltas), element(SectionKind::ShapeSlopes));
    // A later check of all sections refuses a missing one.
    let deltas = deltas.or(slopes).unwrap_or(Element::F32);
    let slopes = slopes.unwrap_or(deltas);
    if slopes != deltas {
        let values = [deltas, slopes].map(|element| element.number().into());
        return Err(loading.refuse(Kind::Mismatch, Some(SectionKind::ShapeSlopes), 0, values));
    }
    words[place::ELEMENT] = deltas.number().into();
    Ok(deltas)
}

/// Checks the content of the shapes: boxes, entries, deltas and slopes.
pub(crate) fn content(skin: &Skin<'_>, loading: &Loading<'_>) -> Checked {
    if skin.shape_len() == 0 {
        return Ok(());
    }
    let blocks = Blocks::of(skin);
    for (shape, row) in blocks.rows.iter().enumerate() {
        // A shape leaves some vertices at rest, so its box must contain 0.
        if !row.last_chunk().is_some_and(|corners| is_inside(corners, [0.0; 3])) {
            return loading.invalid(SectionKind::Shapes, shape);
        }
    }
    check_entries(skin, &blocks, loading)?;
    check_numbers(loading, SectionKind::ShapeDeltas, blocks.deltas)?;
    check_numbers(loading, SectionKind::ShapeSlopes, blocks.slopes)?;
    check_boxes(&blocks, loading)
}

/// Checks that blocks own all entries in order, and that entries own all deltas in order.
fn check_entries(skin: &Skin<'_>, blocks: &Blocks<'_>, loading: &Loading<'_>) -> Checked {
    let counts = skin.counts();
    let mut delta: u32 = 0;
    let mut entries = blocks.entries.iter().map(Entry::read).zip(0..);
    let mut at: u32 = 0;
    for (block, le) in blocks.starts.iter().enumerate() {
        let start = u32::from_le_bytes(*le);
        if start < at || start > counts.entry_len || block == 0 && start > 0 {
            return loading.invalid(SectionKind::ShapeBlocks, block);
        }
        // A start ends the entries of the previous block; the first start ends nothing.
        let vertices = counts.vertex_len as usize - (block.max(1) - 1) * BLOCK;
        let mut above = None;
        for (entry, index) in entries.by_ref().take((start - at) as usize) {
            let section = SectionKind::ShapeEntries;
            check_index(loading, section, index as usize, counts.shape_len, entry.shape as u32)?;
            let beyond = entry.mask.checked_shr(vertices as u32).unwrap_or_default();
            if above >= Some(entry.shape) || entry.mask == 0 || beyond != 0 {
                return loading.invalid(section, index as usize);
            }
            above = Some(entry.shape);
            if entry.start != delta as usize {
                let values = [delta, entry.start as u32];
                return Err(loading.refuse(Kind::Mismatch, Some(section), index as usize, values));
            }
            delta = delta.saturating_add(entry.mask.count_ones());
        }
        at = start;
    }
    for (place, expected, found) in
        [(place::ENTRIES, at, counts.entry_len), (place::DELTAS, delta, counts.delta_len)]
    {
        if expected != found {
            let section = Some(SectionKind::SkinCounts);
            return Err(loading.refuse(Kind::Mismatch, section, place, [expected, found]));
        }
    }
    Ok(())
}

/// Checks that numbers are finite, and that f16 numbers are not subnormal.
fn check_numbers(loading: &Loading<'_>, section: SectionKind, numbers: Numbers<'_>) -> Checked {
    let is_sound = |bits: u16| matches!((bits & 0x7c00, bits & 0x3ff), (0, 0) | (0x400..0x7c00, _));
    let at = match numbers.element {
        Element::F32 => outside(numbers.bytes.as_chunks().0, [-MAGNITUDE_MAX, MAGNITUDE_MAX]),
        Element::F16 => {
            let mut halves = numbers.bytes.as_chunks().0.iter();
            halves.position(|le| !is_sound(u16::from_le_bytes(*le)))
        }
        _ => None,
    };
    match at {
        None => Ok(()),
        Some(at) => Err(loading.refuse(Kind::Float, Some(section), at, [0; 2])),
    }
}

/// Checks that every delta is in its shape's box.
fn check_boxes(blocks: &Blocks<'_>, loading: &Loading<'_>) -> Checked {
    for entry in blocks.entries.iter().map(Entry::read) {
        let Some(row) = blocks.rows.get(entry.shape) else { continue };
        let ([step, ..], Some(corners)) = (floats(row), row.last_chunk()) else { continue };
        for at in (entry.start..).take(entry.mask.count_ones() as usize) {
            let delta = blocks.deltas.read(at).unwrap_or_default().map(|x| step * x);
            if !is_inside(corners, delta) {
                let values = [0, at as u32];
                let section = Some(SectionKind::Shapes);
                return Err(loading.refuse(Kind::Invalid, section, entry.shape, values));
            }
        }
    }
    Ok(())
}
