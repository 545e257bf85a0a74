//! Encodes numbers, rows and matrices as bytes of a file.

use sinew_runtime::envelope::{GroupConfidence, GroupRow};
use sinew_runtime::format::{PartRow, SectionRow};
use sinew_runtime::kernel::{InputRow, KernelRule, OutputRow};

/// Writes floats, little-endian.
pub fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// Writes u32s, little-endian.
pub fn words(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// Writes u16s, little-endian.
pub fn halves(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// Writes section `names`: the part's name, then the names of its joints or ranges.
pub fn names(part: &str, others: &[String]) -> Vec<u8> {
    let (mut ends, mut text) = (Vec::new(), String::new());
    for name in std::iter::once(part).chain(others.iter().map(String::as_str)) {
        text += name;
        ends.push(text.len() as u32);
    }
    [words(&ends), text.into_bytes()].concat()
}

/// Writes a matrix, given as a list of rows, in blocks of 8 rows. Each block is column-major;
/// missing rows of the last block are zero.
pub fn blocks(matrix: &[Vec<f32>]) -> Vec<u8> {
    let mut out = Vec::new();
    for block in matrix.chunks(8) {
        for column in 0..block[0].len() {
            for row in 0..8 {
                out.extend(block.get(row).map_or(0.0, |row| row[column]).to_le_bytes());
            }
        }
    }
    out
}

/// Writes numbers of vertices, given vertex by vertex, in blocks of eight vertices: for each number
/// a row of eight. The last vertex fills the last block.
///
/// - `numbers`: bytes of each number of each vertex.
/// - `len`: numbers of a vertex.
/// - `size`: bytes of a number.
pub fn eights(numbers: &[u8], len: usize, size: usize) -> Vec<u8> {
    let vertices: Vec<_> = numbers.chunks(len * size).collect();
    let mut out = Vec::new();
    for block in vertices.chunks(8) {
        for number in 0..len {
            for lane in 0..8 {
                let own = block[lane.min(block.len() - 1)];
                out.extend(&own[number * size..][..size]);
            }
        }
    }
    out
}

/// Reads what [`eights`] wrote, with the vertices that fill the last block. A block that is not whole is left out.
pub fn from_eights(blocks: &[u8], len: usize, size: usize) -> Vec<u8> {
    let mut out = Vec::new();
    for block in blocks.chunks_exact(8 * len * size) {
        for lane in 0..8 {
            for number in 0..len {
                out.extend(&block[(8 * number + lane) * size..][..size]);
            }
        }
    }
    out
}

/// Writes a row of the part table.
pub fn part_row(row: &PartRow) -> [u8; 4] {
    let mut out = [0; 4];
    out[..2].copy_from_slice(&row.kind.to_le_bytes());
    out[2..].copy_from_slice(&row.flags.to_le_bytes());
    out
}

/// Writes a row of the section table.
pub fn section_row(row: &SectionRow) -> [u8; 16] {
    let mut out = [0; 16];
    out[..2].copy_from_slice(&row.kind.to_le_bytes());
    out[2..4].copy_from_slice(&row.part.to_le_bytes());
    out[4] = row.element;
    out[5] = row.flags;
    out[6..8].copy_from_slice(&row.reserved.to_le_bytes());
    out[8..12].copy_from_slice(&row.offset.to_le_bytes());
    out[12..].copy_from_slice(&row.bytes.to_le_bytes());
    out
}

/// Writes a row of section `groups`.
pub fn group_row(row: &GroupRow) -> [u8; 32] {
    let mut out = [0; 32];
    out[..2].copy_from_slice(&row.joint.to_le_bytes());
    out[2] = row.kernel;
    out[3] = row.certainty_len;
    out[4..6].copy_from_slice(&row.input_len.to_le_bytes());
    out[6..8].copy_from_slice(&row.centre_len.to_le_bytes());
    out[8..10].copy_from_slice(&row.rank.to_le_bytes());
    out[10..12].copy_from_slice(&row.proxy_len.to_le_bytes());
    out[12..16].copy_from_slice(&row.offset.to_le_bytes());
    let GroupConfidence { reach, linear, signal, noise } = row.confidence;
    for (float, value) in out[16..].as_chunks_mut().0.iter_mut().zip([reach, linear, signal, noise])
    {
        *float = value.to_le_bytes();
    }
    out
}

/// Writes section `kernel_rule`.
pub fn kernel_rule(rule: &KernelRule) -> [u8; 12] {
    let mut out = [0; 12];
    out[0] = rule.kernel.number();
    out[1] = rule.kernel.parameter();
    out[2] = rule.query as u8;
    out[3] = rule.normalise as u8;
    out[4..8].copy_from_slice(&rule.fade.0.to_le_bytes());
    out[8..].copy_from_slice(&rule.fade.1.to_le_bytes());
    out
}

/// Writes a row of section `inputs`.
pub fn input_row(row: &InputRow) -> [u8; 16] {
    let mut out = [0; 16];
    out[0] = row.kind.number();
    out[1] = row.euler.map_or(0, |order| order as u8);
    out[4..].copy_from_slice(&floats(&row.axis));
    out
}

/// Writes a row of section `outputs`.
pub fn output_row(row: &OutputRow) -> [u8; 28] {
    let mut out = [0; 28];
    out[0] = row.kind.number();
    out[1] = u8::from(row.is_marked);
    out[4..8].copy_from_slice(&row.range.0.to_le_bytes());
    out[8..12].copy_from_slice(&row.range.1.to_le_bytes());
    out[12..].copy_from_slice(&floats(&row.neutral));
    out
}
