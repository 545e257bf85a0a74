//! Bytes read as a recipe: a golden file, changed piece by piece behind a checksum that holds.
//!
//! Most changes leave a file that may well be accepted, with numbers as far out as the format lets
//! them be: what is refused at once tells little about evaluation.

use crate::GOLDEN;
use crate::pieces::{Pieces, seal};
use arbitrary::{Result, Unstructured};
use sinew_runtime::format::{CORRECTION_MAX, GroupRow, MAGNITUDE_MAX, PartRow, SectionKind};

/// Floats at which something ends: ranges, exactness, what can be squared, what is a number.
const FLOATS: [f32; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    f32::EPSILON,
    1e-45,
    f32::MIN_POSITIVE,
    1e-20,
    -1e-20,
    1024.0,
    -1024.0,
    3.2,
    1e4,
    CORRECTION_MAX,
    -CORRECTION_MAX,
    MAGNITUDE_MAX,
    -MAGNITUDE_MAX,
    1e12,
    1e20,
    -3.4e38,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    2.0,
];

/// Integers at which something ends.
const INTEGERS: [u32; 16] = [
    0,
    1,
    2,
    7,
    8,
    31,
    127,
    128,
    255,
    256,
    0x7fff,
    0xfffe,
    0xffff,
    0x1_0000,
    0x7fff_ffff,
    0xffff_ffff,
];

/// Makes the file that a recipe tells of; any bytes are a recipe.
pub fn file(recipe: &[u8]) -> Vec<u8> {
    let mut u = Unstructured::new(recipe);
    let golden = GOLDEN[u.choose_index(GOLDEN.len()).unwrap_or_default()];
    let mut out = golden.to_vec();
    if let Ok(pieces) = Pieces::of(golden) {
        // A recipe that ends early has done what it could.
        let _ = follow(pieces, &mut u, &mut out);
    }
    out
}

/// Changes the pieces, then the file that they make; `out` is the last whole file.
fn follow(mut pieces: Pieces, u: &mut Unstructured<'_>, out: &mut Vec<u8>) -> Result<()> {
    for _ in 0..u.int_in_range(1..=4)? {
        change(&mut pieces, u)?;
        *out = pieces.file(|_| {});
    }
    match u.int_in_range(0..=15)? {
        0 => {
            // The table says what is not so.
            let (row, value) = (u.choose_index(pieces.sections.len().max(1))?, integer(u)?);
            let is_offset = bool(u)?;
            *out = pieces.file(|rows| {
                let Some(row) = rows.get_mut(row) else { return };
                *(if is_offset { &mut row.offset } else { &mut row.bytes }) = value;
            });
        }
        1 => {
            let at = u.choose_index(out.len())?;
            out[at] = u.arbitrary()?;
            seal(out);
        }
        2 => {
            // The head and the tables say most in the fewest bytes.
            let at = u.choose_index(out.len().min(300))?;
            out[at] ^= 1 << u.int_in_range(0..=7)?;
            seal(out);
        }
        3 => {
            out.truncate(u.choose_index(out.len())?);
            seal(out);
        }
        4 => {
            out.extend(u.bytes(4)?);
            seal(out);
        }
        _ => {}
    }
    Ok(())
}

fn change(pieces: &mut Pieces, u: &mut Unstructured<'_>) -> Result<()> {
    match u.int_in_range(0..=19)? {
        0..=3 => with_section(pieces, u, |bytes, u| set_word(bytes, u)),
        4..=6 => with_section(pieces, u, |bytes, u| fill(bytes, u)),
        7..=9 => with_section(pieces, u, |bytes, u| scale(bytes, u)),
        10 => with_section(pieces, u, |bytes, u| {
            let at = u.choose_index(bytes.len().max(1))?;
            let value = u.arbitrary()?;
            bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte = value);
            Ok(())
        }),
        11 => with_section(pieces, u, |bytes, u| {
            let halves = bytes.as_chunks_mut::<2>().0;
            let (at, value) = (u.choose_index(halves.len().max(1))?, integer(u)? as u16);
            halves.iter_mut().skip(at).take(1).for_each(|half| *half = value.to_le_bytes());
            Ok(())
        }),
        12 => with_section(pieces, u, |bytes, u| {
            let len = bytes.len().saturating_add_signed(u.int_in_range(-16..=16)?);
            bytes.resize(len, 0);
            Ok(())
        }),
        13 => section_row(pieces, u),
        14 => part_row(pieces, u),
        15 => vertices(pieces, u),
        16 => {
            let at = u.int_in_range(4..=9)?;
            pieces.head[at] = integer(u)? as u8;
            Ok(())
        }
        _ => group(pieces, u),
    }
}

/// Changes the content of a section, the large ones no likelier than the small.
fn with_section(
    pieces: &mut Pieces,
    u: &mut Unstructured<'_>,
    change: impl FnOnce(&mut Vec<u8>, &mut Unstructured<'_>) -> Result<()>,
) -> Result<()> {
    let at = u.choose_index(pieces.sections.len().max(1))?;
    pieces.sections.get_mut(at).map_or(Ok(()), |(_, bytes)| change(bytes, u))
}

fn set_word(bytes: &mut [u8], u: &mut Unstructured<'_>) -> Result<()> {
    let words = bytes.as_chunks_mut::<4>().0;
    let (at, value) = (u.choose_index(words.len().max(1))?, float(u)?);
    words.iter_mut().skip(at).take(1).for_each(|word| *word = value.to_le_bytes());
    Ok(())
}

/// Fills a run of words.
fn fill(bytes: &mut [u8], u: &mut Unstructured<'_>) -> Result<()> {
    let (words, value) = (run(bytes, u)?, float(u)?);
    words.fill(value.to_le_bytes());
    Ok(())
}

/// Multiplies a run of floats by a power of ten, and half of the time keeps them within what the
/// format allows.
fn scale(bytes: &mut [u8], u: &mut Unstructured<'_>) -> Result<()> {
    let words = run(bytes, u)?;
    let factor = 10f32.powi(u.int_in_range(-12..=12)?) * if bool(u)? { 1.0 } else { -1.0 };
    let most =
        if bool(u)? { [CORRECTION_MAX, MAGNITUDE_MAX][u.choose_index(2)?] } else { f32::MAX };
    for word in words {
        *word = (f32::from_le_bytes(*word) * factor).clamp(-most, most).to_le_bytes();
    }
    Ok(())
}

/// Chooses a run of words, half of the time all.
fn run<'a>(bytes: &'a mut [u8], u: &mut Unstructured<'_>) -> Result<&'a mut [[u8; 4]]> {
    let words = bytes.as_chunks_mut::<4>().0;
    if words.is_empty() || bool(u)? {
        return Ok(words);
    }
    let start = u.choose_index(words.len())?;
    let len = u.int_in_range(0..=words.len() - start)?;
    Ok(&mut words[start..start + len])
}

fn section_row(pieces: &mut Pieces, u: &mut Unstructured<'_>) -> Result<()> {
    let at = u.choose_index(pieces.sections.len().max(1))?;
    let value = integer(u)?;
    match (u.int_in_range(0..=5)?, pieces.sections.get_mut(at)) {
        (0, Some((row, _))) => row.kind = value as u16,
        (1, Some((row, _))) => row.part = value as u8,
        (2, Some((row, _))) => row.flags = value as u8,
        (3, Some(_)) => drop(pieces.sections.remove(at)),
        (4, Some(section)) => {
            let again = section.clone();
            pieces.sections.push(again);
        }
        (_, Some(_)) => {
            let other = u.choose_index(pieces.sections.len())?;
            pieces.sections.swap(at, other);
        }
        (_, None) => {}
    }
    Ok(())
}

fn part_row(pieces: &mut Pieces, u: &mut Unstructured<'_>) -> Result<()> {
    let Some(row) = pieces.parts.first_mut() else { return Ok(()) };
    match u.int_in_range(0..=6)? {
        0 => {
            let at = u.choose_index(row.counts.len())?;
            row.counts[at] = integer(u)?;
        }
        1 => {
            let at = u.choose_index(row.counts.len())?;
            row.counts[at] = row.counts[at].wrapping_add_signed(u.int_in_range(-2..=2)?);
        }
        2 => row.predictor = u.int_in_range(0..=4)?,
        3 => row.kind = u.int_in_range(0..=5)?,
        4 => row.flags = integer(u)? as u16,
        5 => row.figures[u.choose_index(5)?] = float(u)?,
        _ => {
            let more =
                PartRow { kind: u.int_in_range(0..=5)?, flags: u.int_in_range(0..=1)?, ..*row };
            pieces.parts.push(more);
        }
    }
    Ok(())
}

/// Drops vertices or the tangents: a sound file of another shape.
fn vertices(pieces: &mut Pieces, u: &mut Unstructured<'_>) -> Result<()> {
    if bool(u)? {
        pieces.sections.retain(|(row, _)| row.kind != SectionKind::RestTangents.number());
        return Ok(());
    }
    let vertex_len = pieces.parts.first().map_or(0, |row| row.counts[0]);
    keep_vertices(pieces, u.int_in_range(0..=vertex_len.min(64))?);
    Ok(())
}

/// Keeps the first vertices only, everywhere; of none there are no rest boxes.
pub(crate) fn keep_vertices(pieces: &mut Pieces, vertex_len: u32) {
    let Some(row) = pieces.parts.first_mut() else { return };
    row.counts[0] = vertex_len;
    let influence_len = row.counts[3] as usize;
    for (kind, bytes) in [
        (SectionKind::RestPositions, 12),
        (SectionKind::RestNormals, 12),
        (SectionKind::RestTangents, 16),
        (SectionKind::InfluenceIndices, influence_len.saturating_mul(2)),
        (SectionKind::InfluenceWeights, influence_len.saturating_mul(4)),
    ] {
        if let Some(content) = pieces.section(kind) {
            content.truncate((vertex_len as usize).saturating_mul(bytes));
        }
    }
    if vertex_len == 0
        && let Some(boxes) = pieces.section(SectionKind::RestBoxes)
    {
        // Least x is above greatest x: a box around nothing.
        let (words, _) = boxes.as_chunks_mut::<4>();
        words.chunks_mut(6).for_each(|rest_box| rest_box[0] = MAGNITUDE_MAX.to_le_bytes());
    }
}

fn group(pieces: &mut Pieces, u: &mut Unstructured<'_>) -> Result<()> {
    let Some(rows) = pieces.section(SectionKind::Groups) else { return Ok(()) };
    let rows = rows.as_chunks_mut::<{ GroupRow::BYTES }>().0;
    let at = u.choose_index(rows.len().max(1))?;
    let Some(bytes) = rows.get_mut(at) else { return Ok(()) };
    let mut row = GroupRow::from_bytes(bytes);
    match u.int_in_range(0..=10)? {
        0 => row.joint = integer(u)? as u16,
        1 => row.kernel = u.arbitrary()?,
        2 => row.reserved = integer(u)? as u8,
        3 => row.input_len = integer(u)? as u16,
        4 => row.centre_len = integer(u)? as u16,
        5 => row.rank = integer(u)? as u16,
        6 => row.proxy_len = integer(u)? as u16,
        7 => row.offset = integer(u)?,
        8 => row.fade_start = float(u)?,
        9 => row.fade_end = float(u)?,
        _ => row.kernel = u.int_in_range(8..=11)?,
    }
    *bytes = row.to_bytes();
    Ok(())
}

fn bool(u: &mut Unstructured<'_>) -> Result<bool> {
    u.arbitrary()
}

/// Draws a float, mostly one at which something ends.
pub(crate) fn float(u: &mut Unstructured<'_>) -> Result<f32> {
    if u.int_in_range(0..=3)? == 0 { u.arbitrary() } else { u.choose(&FLOATS).copied() }
}

fn integer(u: &mut Unstructured<'_>) -> Result<u32> {
    if u.int_in_range(0..=3)? == 0 { u.arbitrary() } else { u.choose(&INTEGERS).copied() }
}
