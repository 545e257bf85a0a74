//! Reads bytes as a recipe: a valid file, changed piece by piece behind a valid checksum.
//!
//! Most changes leave a file that the runtime may accept, with the most extreme numbers that the
//! format allows. A file that is refused at once hardly tests evaluation.

use crate::files;
use arbitrary::{Result, Unstructured};
use models::{Content, Pieces, eights, from_eights, group_row, seal};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_runtime::envelope::GroupRow;
use sinew_runtime::format::{CORRECTION_MAX, Element, MAGNITUDE_MAX, PartRow, SectionKind};
use sinew_runtime::skin::NO_ENVELOPE;

/// Length of a random recipe in bytes; few recipes use all.
const RECIPE_BYTES: usize = 96;

/// Boundary values of floats: ranges, exactness, squares that overflow, NaN and infinities.
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

/// Boundary values of integers.
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

/// Makes the file of a recipe; all bytes are a recipe.
pub fn file(recipe: &[u8]) -> Vec<u8> {
    let mut u = Unstructured::new(recipe);
    let files = files();
    let sound = &files[u.choose_index(files.len()).unwrap_or_default()];
    let mut out = sound.clone();
    if let Ok(pieces) = Pieces::of(sound) {
        // A recipe that ends early has made all its changes.
        let _ = follow(pieces, &mut u, &mut out);
    }
    out
}

/// Makes mutant `number`, with a valid checksum. Three of four mutants follow a recipe; the fourth
/// has bits flipped anywhere.
pub fn mutant(number: u64) -> Vec<u8> {
    let mut random = ChaCha8Rng::seed_from_u64(number);
    if !number.is_multiple_of(4) {
        let mut bytes = [0; RECIPE_BYTES];
        random.fill_bytes(&mut bytes);
        return file(&bytes);
    }
    let files = files();
    let mut mutant = files[random.random_range(0..files.len())].clone();
    for _ in 0..random.random_range(1..=8) {
        let at = random.random_range(0..mutant.len());
        mutant[at] ^= 1 << random.random_range(0..8);
    }
    seal(&mut mutant);
    mutant
}

/// Changes the pieces, then the file made of them; `out` is the last complete file.
fn follow(mut pieces: Pieces, u: &mut Unstructured<'_>, out: &mut Vec<u8>) -> Result<()> {
    for _ in 0..u.int_in_range(1..=4)? {
        change(&mut pieces, u)?;
        *out = pieces.bytes();
    }
    match u.int_in_range(0..=15)? {
        0 => {
            // The table of sections states a wrong value.
            let (row, value) = (u.choose_index(pieces.sections.len().max(1))?, integer(u)?);
            let is_offset = bool(u)?;
            *out = pieces.bytes_with_rows(|rows| {
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
            // The first bytes, the head and the tables, affect the most.
            let at = u.choose_index(out.len().min(400))?;
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
    match u.int_in_range(0..=21)? {
        0..=3 => with_floats(pieces, u, |bytes, u| set_word(bytes, u)),
        4..=6 => with_floats(pieces, u, |bytes, u| fill(bytes, u)),
        7..=9 => with_floats(pieces, u, |bytes, u| scale(bytes, u)),
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
            // Not the magic; the checksum is written last.
            let at = u.int_in_range(4..=20)?;
            pieces.head[at] = integer(u)? as u8;
            Ok(())
        }
        17 => counts(pieces, u),
        18 => kernel(pieces, u),
        19 => shapes(pieces, u),
        _ => group(pieces, u),
    }
}

/// Changes the content of a section; large sections are as likely as small sections.
fn with_section(
    pieces: &mut Pieces,
    u: &mut Unstructured<'_>,
    change: impl FnOnce(&mut Vec<u8>, &mut Unstructured<'_>) -> Result<()>,
) -> Result<()> {
    let at = u.choose_index(pieces.sections.len().max(1))?;
    pieces.sections.get_mut(at).map_or(Ok(()), |content| change(&mut content.bytes, u))
}

/// Changes the content of a section of floats, or of records that contain floats. Directions are
/// mostly rotated, because few other changes keep their length.
fn with_floats(
    pieces: &mut Pieces,
    u: &mut Unstructured<'_>,
    change: impl FnOnce(&mut Vec<u8>, &mut Unstructured<'_>) -> Result<()>,
) -> Result<()> {
    let elements = [Element::F32, Element::Mixed].map(Element::number);
    let floats = pieces.sections.iter_mut().filter(|content| elements.contains(&content.element));
    let mut floats: Vec<_> = floats.collect();
    let at = u.choose_index(floats.len().max(1))?;
    let Some(Content { kind, bytes, .. }) = floats.get_mut(at) else { return Ok(()) };
    let floats_of_one = match SectionKind::from_number(*kind) {
        Some(SectionKind::RestNormals) => 3,
        Some(SectionKind::RestTangents) => 4,
        _ => return change(bytes, u),
    };
    if u.int_in_range(0..=3)? == 0 {
        return change(bytes, u);
    }
    let mut numbers = from_eights(bytes, floats_of_one, 4);
    turn(&mut numbers, floats_of_one, u)?;
    *bytes = eights(&numbers, floats_of_one, 4);
    Ok(())
}

/// Turns directions by quarter turns and mirrors them; a few become invalid.
fn turn(bytes: &mut [u8], floats_of_one: usize, u: &mut Unstructured<'_>) -> Result<()> {
    let words = bytes.as_chunks_mut::<4>().0;
    let (by, is_mirrored) = (u.choose_index(3)?, bool(u)?);
    for direction in words.chunks_exact_mut(floats_of_one) {
        direction[..3].rotate_left(by);
        let first = f32::from_le_bytes(direction[0]);
        direction[0] = (if is_mirrored { -first } else { first }).to_le_bytes();
    }
    if u.int_in_range(0..=3)? == 0 {
        let at = u.choose_index((words.len() / floats_of_one).max(1))?;
        let none = words.chunks_exact_mut(floats_of_one).skip(at).take(1);
        none.for_each(|direction| direction[..3].fill([0; 4]));
    }
    Ok(())
}

fn set_word(bytes: &mut [u8], u: &mut Unstructured<'_>) -> Result<()> {
    let words = bytes.as_chunks_mut::<4>().0;
    let (at, value) = (u.choose_index(words.len().max(1))?, float(u)?);
    words.iter_mut().skip(at).take(1).for_each(|word| *word = value.to_le_bytes());
    Ok(())
}

/// Fills a run of words with one value.
fn fill(bytes: &mut [u8], u: &mut Unstructured<'_>) -> Result<()> {
    let (words, value) = (run(bytes, u)?, float(u)?);
    words.fill(value.to_le_bytes());
    Ok(())
}

/// Multiplies a run of floats by a power of ten; half of the time clamps them to the range of the
/// format.
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

/// Chooses a run of words, half of the time all words.
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
    match (u.int_in_range(0..=7)?, pieces.sections.get_mut(at)) {
        (0, Some(row)) => row.kind = value as u16,
        (1, Some(row)) => row.part = value as u16,
        (2, Some(row)) => row.flags = value as u8,
        (3, Some(row)) => row.element = value as u8,
        (4, Some(row)) => row.reserved = value as u16,
        (5, Some(_)) => drop(pieces.sections.remove(at)),
        (6, Some(section)) => {
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
    let at = u.choose_index(pieces.parts.len().max(1))?;
    let Some(row) = pieces.parts.get_mut(at) else { return Ok(()) };
    match u.int_in_range(0..=4)? {
        0 => row.kind = u.int_in_range(0..=5)?,
        1 => row.flags = integer(u)? as u16,
        2 => {
            pieces.parts.remove(at);
        }
        3 => {
            let other = u.choose_index(pieces.parts.len())?;
            pieces.parts.swap(at, other);
        }
        _ => {
            let more = PartRow { kind: u.int_in_range(0..=5)?, flags: u.int_in_range(0..=1)? };
            pieces.parts.push(more);
        }
    }
    Ok(())
}

/// Changes a count of a part, or the envelope that a skin follows.
fn counts(pieces: &mut Pieces, u: &mut Unstructured<'_>) -> Result<()> {
    let parts = [SectionKind::EnvelopeCounts, SectionKind::SkinCounts, SectionKind::KernelCounts];
    let kinds = [&parts[..], &[SectionKind::PriorCounts, SectionKind::ViewsCounts]].concat();
    let is_counts = |kind: u16| kinds.iter().any(|own| own.number() == kind);
    let own = pieces.sections.iter_mut().filter(|content| is_counts(content.kind));
    let mut own: Vec<_> = own.map(|content| content.bytes.as_chunks_mut::<4>().0).collect();
    let at = u.choose_index(own.len().max(1))?;
    let Some(words) = own.get_mut(at) else { return Ok(()) };
    let at = u.choose_index(words.len().max(1))?;
    let Some(word) = words.get_mut(at) else { return Ok(()) };
    let value = match u.int_in_range(0..=3)? {
        0 => integer(u)?,
        1 => NO_ENVELOPE,
        2 => u.int_in_range(0..=5)?,
        _ => u32::from_le_bytes(*word).wrapping_add_signed(u.int_in_range(-2..=2)?),
    };
    *word = value.to_le_bytes();
    Ok(())
}

/// Drops vertices, tangents, ranges, or the envelope: a valid file of another shape.
fn vertices(pieces: &mut Pieces, u: &mut Unstructured<'_>) -> Result<()> {
    match u.int_in_range(0..=3)? {
        0 => pieces.sections.retain(|content| content.kind != SectionKind::RestTangents.number()),
        1 => {
            let Some(ranges) = pieces.find(SectionKind::Ranges) else { return Ok(()) };
            let words = ranges.as_chunks_mut::<4>().0;
            let (at, value) = (u.choose_index(words.len().max(1))?, u.int_in_range(0..=32u32)?);
            words.iter_mut().skip(at).take(1).for_each(|word| *word = value.to_le_bytes());
        }
        2 if pieces.parts.len() == 2 => pieces.loosen(),
        _ => {
            let vertex_len =
                pieces.word(SectionKind::SkinCounts, 0).map_or(0, |word| u32::from_le_bytes(*word));
            pieces.keep_vertices(u.int_in_range(0..=vertex_len.min(64))?);
        }
    }
    Ok(())
}

fn group(pieces: &mut Pieces, u: &mut Unstructured<'_>) -> Result<()> {
    let Some(rows) = pieces.find(SectionKind::Groups) else { return Ok(()) };
    let rows = rows.as_chunks_mut::<{ GroupRow::BYTES }>().0;
    let at = u.choose_index(rows.len().max(1))?;
    let Some(bytes) = rows.get_mut(at) else { return Ok(()) };
    let mut row = GroupRow::from_bytes(bytes);
    match u.int_in_range(0..=12)? {
        0 => row.joint = integer(u)? as u16,
        1 => row.kernel = u.arbitrary()?,
        2 => row.certainty_len = integer(u)? as u8,
        3 => row.input_len = integer(u)? as u16,
        4 => row.centre_len = integer(u)? as u16,
        5 => row.rank = integer(u)? as u16,
        6 => row.proxy_len = integer(u)? as u16,
        7 => row.offset = integer(u)?,
        8 => row.confidence.reach = float(u)?,
        9 => row.confidence.linear = float(u)?,
        10 => row.confidence.signal = float(u)?,
        11 => row.confidence.noise = float(u)?,
        _ => row.kernel = u.int_in_range(8..=11)?,
    }
    *bytes = group_row(&row);
    Ok(())
}

/// Changes a number of a kernel's rule, inputs, outputs or terms.
fn kernel(pieces: &mut Pieces, u: &mut Unstructured<'_>) -> Result<()> {
    let kinds =
        [SectionKind::KernelRule, SectionKind::Inputs, SectionKind::Outputs, SectionKind::Terms];
    let (kind, element) = (*u.choose(&kinds)?, [12, 16, 28, 4]);
    let bytes = element[kinds.iter().position(|own| *own == kind).unwrap_or_default()];
    let part = u.choose_index(pieces.parts.len().max(1))? as u16;
    let own = pieces.sections.iter_mut().filter(|content| content.kind == kind.number());
    let mut own: Vec<_> = own.collect();
    own.sort_by_key(|content| content.part.abs_diff(part));
    let Some(content) = own.into_iter().next() else { return Ok(()) };
    let at = u.choose_index((content.bytes.len() / bytes).max(1))? * bytes;
    let Some(row) = content.bytes.get_mut(at..at + bytes) else { return Ok(()) };
    // The first word holds no float.
    row[u.choose_index(4)?] = u.int_in_range(0..=14)?;
    Ok(())
}

/// Changes a word of the starts of shape blocks, or of their entries.
fn shapes(pieces: &mut Pieces, u: &mut Unstructured<'_>) -> Result<()> {
    let kinds = [SectionKind::ShapeBlocks, SectionKind::ShapeEntries].map(SectionKind::number);
    let own = pieces.sections.iter_mut().filter(|content| kinds.contains(&content.kind));
    let mut own: Vec<_> = own.map(|content| content.bytes.as_chunks_mut::<4>().0).collect();
    let at = u.choose_index(own.len().max(1))?;
    let Some(words) = own.get_mut(at) else { return Ok(()) };
    let at = u.choose_index(words.len().max(1))?;
    let Some(word) = words.get_mut(at) else { return Ok(()) };
    let value = match u.int_in_range(0..=2)? {
        0 => integer(u)?,
        1 => u32::from_le_bytes(*word) ^ 1 << u.int_in_range(0..=31)?,
        _ => u32::from_le_bytes(*word).wrapping_add_signed(u.int_in_range(-2..=2)?),
    };
    *word = value.to_le_bytes();
    Ok(())
}

fn bool(u: &mut Unstructured<'_>) -> Result<bool> {
    u.arbitrary()
}

/// Draws a float, mostly a boundary value.
pub(crate) fn float(u: &mut Unstructured<'_>) -> Result<f32> {
    if u.int_in_range(0..=3)? == 0 { u.arbitrary() } else { u.choose(&FLOATS).copied() }
}

fn integer(u: &mut Unstructured<'_>) -> Result<u32> {
    if u.int_in_range(0..=3)? == 0 { u.arbitrary() } else { u.choose(&INTEGERS).copied() }
}
