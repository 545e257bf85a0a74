//! Pictures as pixels, and a PNG reader.

use png::{ColorType, Decoder, Limits, Transformations};
use std::io::{BufRead, Seek};

/// Largest number of pixels of a picture: 8192 x 8192, 256 MiB as bytes.
const MOST: usize = 1 << 26;

/// Pixels from the upper left, row by row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Pixels {
    /// Width and height.
    pub(crate) size: [usize; 2],
    /// Red, green, blue and alpha, not premultiplied.
    pub(crate) rgba: Vec<u8>,
}

impl Pixels {
    /// Makes a fully transparent picture.
    pub(crate) fn empty(size: [usize; 2]) -> Self {
        Self { size, rgba: vec![0; 4 * size[0] * size[1]] }
    }

    /// Copies another picture into this one; parts outside are cut off.
    ///
    /// - `corner`: x and y at which the other picture's upper left pixel lies.
    pub(crate) fn place(&mut self, other: &Self, corner: [i64; 2]) {
        let span = |axis: usize| {
            let (own, len) = (self.size[axis] as i64, other.size[axis] as i64);
            (corner[axis].clamp(0, own), corner[axis].saturating_add(len).clamp(0, own))
        };
        let ((left, right), (top, bottom)) = (span(0), span(1));
        let len = 4 * (right - left) as usize;
        for y in top..bottom {
            let to = 4 * (y as usize * self.size[0] + left as usize);
            let row = (y - corner[1]) as usize * other.size[0];
            let from = 4 * (row + (left - corner[0]) as usize);
            self.rgba[to..to + len].copy_from_slice(&other.rgba[from..from + len]);
        }
    }
}

/// Checks that a picture of this width and height fits into memory.
///
/// # Errors
/// The fault, in words.
pub(crate) fn check_size([width, height]: [usize; 2]) -> Result<(), String> {
    match width.checked_mul(height) {
        Some(1..=MOST) => Ok(()),
        Some(0) => Err(format!("it has no pixels: {width} x {height}")),
        _ => Err(format!("{width} x {height} pixels, expected at most {MOST} in all")),
    }
}

/// Returns the width and height of a PNG.
///
/// # Errors
/// The fault, in words.
pub(crate) fn png_size(bytes: impl BufRead + Seek) -> Result<[usize; 2], String> {
    let reader = Decoder::new(bytes).read_info().map_err(|error| error.to_string())?;
    Ok([reader.info().width as usize, reader.info().height as usize])
}

/// Decodes a PNG of any colour type and depth.
///
/// # Errors
/// The fault, in words.
pub(crate) fn read_png(bytes: impl BufRead + Seek) -> Result<Pixels, String> {
    let wrong = |error: png::DecodingError| error.to_string();
    let mut decoder = Decoder::new_with_limits(bytes, Limits { bytes: 8 * MOST });
    decoder.set_transformations(Transformations::normalize_to_color8() | Transformations::ALPHA);
    let mut reader = decoder.read_info().map_err(wrong)?;
    let size = [reader.info().width as usize, reader.info().height as usize];
    check_size(size)?;
    let len = reader.output_buffer_size().ok_or("it is too large")?;
    let mut bytes = vec![0; len];
    let frame = reader.next_frame(&mut bytes).map_err(wrong)?;
    bytes.truncate(frame.buffer_size());
    let rgba = match frame.color_type {
        ColorType::Rgba => bytes,
        ColorType::GrayscaleAlpha => {
            let (pixels, _) = bytes.as_chunks::<2>();
            pixels.iter().flat_map(|[grey, alpha]| [*grey, *grey, *grey, *alpha]).collect()
        }
        other => return Err(format!("{other:?} is not read")),
    };
    Ok(Pixels { size, rgba })
}

/// Multiplies two shares of 255, rounded.
pub(crate) fn product(a: u8, b: u8) -> u8 {
    ((u32::from(a) * u32::from(b) + 127) / 255) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_placed_where_they_overlap() {
        let mut canvas = Pixels::empty([3, 2]);
        let other = Pixels { size: [2, 2], rgba: (1..=16).collect() };
        canvas.place(&other, [-1, 1]);
        let mut expected = vec![0; 24];
        expected[12..16].copy_from_slice(&[5, 6, 7, 8]);
        assert_eq!(canvas.rgba, expected);
        for corner in [[-2, 0], [3, 0], [0, -2], [0, 2], [i64::MIN, i64::MAX]] {
            let before = canvas.clone();
            canvas.place(&other, corner);
            assert_eq!(canvas, before, "{corner:?}");
        }
    }

    #[test]
    fn sizes_that_no_memory_holds_are_refused() {
        assert!(check_size([8192, 8192]).is_ok());
        for size in [[8192, 8193], [usize::MAX, 2], [0, 5]] {
            assert!(check_size(size).is_err(), "{size:?}");
        }
    }
}
