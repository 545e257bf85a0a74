//! A big-endian byte reader, and the decoders of a layer's channels: raw, run-length coded or deflated, with 8 or 16
//! bits a sample.

use crate::Error;
use crate::formats::layered::tree::damaged;
use flate2::read::ZlibDecoder;
use std::io::Read;

/// The unread rest of some bytes, and its position in the file.
#[derive(Clone, Copy)]
pub(super) struct Bytes<'a> {
    pub(super) left: &'a [u8],
    /// Position of the next byte in the file.
    pub(super) start: usize,
}

impl<'a> Bytes<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { left: bytes, start: 0 }
    }

    pub(super) fn len(&self) -> usize {
        self.left.len()
    }

    /// Reads the next `len` bytes.
    ///
    /// # Errors
    /// Fewer bytes are left.
    pub(super) fn take(&mut self, len: usize) -> Result<Self, Error> {
        let found = self.left.len();
        let Some((own, left)) = self.left.split_at_checked(len) else {
            let at = self.start;
            return Err(damaged(format!("expected {len} bytes at byte {at}, found {found}")));
        };
        let taken = Self { left: own, start: self.start };
        (self.left, self.start) = (left, self.start + len);
        Ok(taken)
    }

    /// Reads a number of bytes, then as many bytes.
    pub(super) fn block(&mut self) -> Result<Self, Error> {
        let len = self.u32()? as usize;
        self.take(len)
    }

    pub(super) fn array<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let mut out = [0; N];
        out.copy_from_slice(self.take(N)?.left);
        Ok(out)
    }

    pub(super) fn u8(&mut self) -> Result<u8, Error> {
        Ok(u8::from_be_bytes(self.array()?))
    }

    pub(super) fn u16(&mut self) -> Result<u16, Error> {
        Ok(u16::from_be_bytes(self.array()?))
    }

    pub(super) fn i16(&mut self) -> Result<i16, Error> {
        Ok(i16::from_be_bytes(self.array()?))
    }

    pub(super) fn u32(&mut self) -> Result<u32, Error> {
        Ok(u32::from_be_bytes(self.array()?))
    }

    pub(super) fn i32(&mut self) -> Result<i32, Error> {
        Ok(i32::from_be_bytes(self.array()?))
    }
}

/// Finds a block by its key among blocks padded to a multiple of `padding` bytes.
pub(super) fn blocks<'a>(
    mut left: Bytes<'a>,
    key: &[u8; 4],
    padding: usize,
) -> Result<Option<Bytes<'a>>, Error> {
    while left.len() >= 12 {
        let signature: [u8; 4] = left.array()?;
        if !matches!(&signature, b"8BIM" | b"8B64") {
            break;
        }
        let found: [u8; 4] = left.array()?;
        let block = left.block()?;
        if found == *key {
            return Ok(Some(block));
        }
        let rest = block.len().next_multiple_of(padding) - block.len();
        left.take(rest.min(left.len()))?;
    }
    Ok(None)
}

/// Decodes a channel into one byte a pixel.
///
/// - `data`: the channel's compression, then its bytes.
/// - `size`: width and height in pixels.
/// - `sample`: bytes a sample, 1 or 2.
///
/// # Errors
/// The fault, in words.
pub(super) fn decode(data: &[u8], size: [usize; 2], sample: usize) -> Result<Vec<u8>, String> {
    let row = size[0] * sample;
    let len = row * size[1];
    if len == 0 {
        return Ok(Vec::new());
    }
    let (compression, data) = data.split_at_checked(2).ok_or("a channel has no data")?;
    let samples = match compression {
        [0, 0] => data.get(..len).ok_or("a channel is cut off")?.to_vec(),
        [0, 1] => decode_runs(data, row, size[1])?,
        [0, 2] => inflate(data, len)?,
        [0, 3] => undo_differences(inflate(data, len)?, row, sample),
        _ => return Err(format!("compression {compression:?} of a channel is not known")),
    };
    Ok(match sample {
        1 => samples,
        // 65535 is white.
        _ => samples.as_chunks::<2>().0.iter().map(|own| byte(u16::from_be_bytes(*own))).collect(),
    })
}

fn byte(sample: u16) -> u8 {
    ((u32::from(sample) + 128) / 257) as u8
}

/// Decodes rows of PackBits; the lengths of all rows come first.
fn decode_runs(data: &[u8], row: usize, rows: usize) -> Result<Vec<u8>, String> {
    let cut_off = |_| "a channel is cut off".to_owned();
    let mut lengths = Bytes::new(data);
    let mut data = lengths;
    data.take(2 * rows).map_err(cut_off)?;
    let mut out = Vec::new();
    for number in 0..rows {
        let len = lengths.u16().map_err(cut_off)?;
        let mut own = data.take(len.into()).map_err(cut_off)?;
        let end = (number + 1) * row;
        while out.len() < end && own.len() > 0 {
            let head = own.u8().map_err(cut_off)?;
            let left = end - out.len();
            match head {
                0..128 => {
                    let bytes = own.take(usize::from(head) + 1).map_err(cut_off)?.left;
                    out.extend(&bytes[..bytes.len().min(left)]);
                }
                128 => {}
                129.. => {
                    let byte = own.u8().map_err(cut_off)?;
                    out.resize(out.len() + (257 - usize::from(head)).min(left), byte);
                }
            }
        }
        if out.len() < end {
            return Err(format!("row {number} of a channel is too short"));
        }
    }
    Ok(out)
}

/// Inflates `len` bytes.
fn inflate(data: &[u8], len: usize) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    let read = ZlibDecoder::new(data).take(len as u64).read_to_end(&mut out);
    read.map_err(|error| format!("a channel cannot be inflated: {error}"))?;
    if out.len() < len { Err("a channel is cut off".to_owned()) } else { Ok(out) }
}

/// Sums samples that are stored as differences from their left neighbours.
fn undo_differences(mut bytes: Vec<u8>, row: usize, sample: usize) -> Vec<u8> {
    for row in bytes.chunks_mut(row) {
        if sample == 1 {
            (1..row.len()).for_each(|x| row[x] = row[x].wrapping_add(row[x - 1]));
            continue;
        }
        let mut sum = 0u16;
        for own in row.as_chunks_mut::<2>().0 {
            sum = sum.wrapping_add(u16::from_be_bytes(*own));
            *own = sum.to_be_bytes();
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::ZlibEncoder;
    use std::io::Write;

    fn deflated(kind: u8, bytes: &[u8]) -> Vec<u8> {
        let mut out = ZlibEncoder::new(vec![0, kind], Compression::default());
        out.write_all(bytes).unwrap();
        out.finish().unwrap()
    }

    #[test]
    fn all_compressions_give_the_same_rows() {
        let rows = [7, 7, 7, 9, 1, 2, 3, 4];
        let raw = [&[0, 0][..], &rows].concat();
        assert_eq!(decode(&raw, [4, 2], 1).unwrap(), rows);
        // Three times 7, then one literal byte; a byte without meaning, then four literal bytes.
        let runs = [0, 1, 0, 4, 0, 6, 254, 7, 0, 9, 128, 3, 1, 2, 3, 4];
        assert_eq!(decode(&runs, [4, 2], 1).unwrap(), rows);
        assert_eq!(decode(&deflated(2, &rows), [4, 2], 1).unwrap(), rows);
        let steps = [7, 0, 0, 2, 1, 1, 1, 1];
        assert_eq!(decode(&deflated(3, &steps), [4, 2], 1).unwrap(), rows);
    }

    #[test]
    fn sixteen_bits_are_rounded_to_eight() {
        let deep = [[0xff, 0xff], [0, 0], [0x7f, 0xff], [0x01, 0x80]];
        let raw = [&[0, 0][..], deep.as_flattened()].concat();
        assert_eq!(decode(&raw, [2, 2], 2).unwrap(), [255, 0, 127, 1]);
        // Differences of 16-bit samples: 0x00ff, then 0x0101 more.
        let steps = deflated(3, &[0x00, 0xff, 0x01, 0x01]);
        assert_eq!(decode(&steps, [2, 1], 2).unwrap(), [1, 2]);
    }

    #[test]
    fn channels_that_end_too_early_are_refused() {
        let whole: [&[u8]; 4] = [
            &[0, 0, 1, 2, 3, 4],
            &[0, 1, 0, 2, 0, 2, 255, 7, 255, 8],
            &deflated(2, &[1, 2, 3, 4]),
            &deflated(3, &[1, 2, 3, 4]),
        ];
        for bytes in whole {
            assert_eq!(decode(bytes, [2, 2], 1).unwrap().len(), 4);
            // The checksum at the end of deflated bytes is not needed.
            for end in 0..bytes.len().min(8) {
                if bytes[1] < 2 || end < 4 {
                    let cut = &bytes[..end.min(bytes.len() - 1)];
                    assert!(decode(cut, [2, 2], 1).is_err(), "{bytes:?} {end}");
                }
            }
        }
        assert!(decode(&[0, 4, 1, 1, 1, 1], [2, 2], 1).unwrap_err().contains("not known"));
        assert!(decode(&[0, 2, 9, 9, 9, 9], [2, 2], 1).unwrap_err().contains("inflated"));
    }

    #[test]
    fn inflating_stops_at_the_expected_length() {
        let bomb = deflated(2, &vec![5; 1 << 22]);
        assert!(bomb.len() < 1 << 13);
        assert_eq!(decode(&bomb, [2, 2], 1).unwrap(), [5; 4]);
    }
}
