//! A picture of pixels.

use super::camera::Resolution;
use super::colour::Colour;
use png::{BitDepth, ColorType, Encoder, EncodingError};

/// Pixels from the upper left, row by row: red, green, blue, and how far each is covered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width and height.
    pub size: Resolution,
    /// Pixels, 4 bytes each.
    pub rgba: Vec<u8>,
}

impl Picture {
    /// Makes a picture of one colour.
    pub fn filled(width: usize, height: usize, [r, g, b]: Colour) -> Self {
        let rgba = [r, g, b, 0xff].repeat(width * height);
        Self { size: Resolution { width, height }, rgba }
    }

    /// Returns a pixel's colour.
    pub fn colour(&self, at: [usize; 2]) -> Colour {
        let pixel = self.index(at).map(|index| [0, 1, 2].map(|c| self.rgba[index + c]));
        pixel.unwrap_or_default()
    }

    /// Sets a pixel's colour.
    pub fn set(&mut self, at: [usize; 2], colour: Colour) {
        self.mix(at, colour, 1.0);
    }

    /// Mixes a share of a colour into a pixel; beyond the picture there is none.
    pub fn mix(&mut self, at: [usize; 2], colour: Colour, share: f64) {
        let Some(index) = self.index(at) else { return };
        for (byte, colour) in self.rgba[index..].iter_mut().zip(colour) {
            *byte = (f64::from(*byte) * (1.0 - share) + f64::from(colour) * share).round() as u8;
        }
    }

    /// Lays the picture, whose colours are not multiplied by their alpha, on white.
    #[must_use]
    pub fn on_white(&self) -> Self {
        let mut out = self.clone();
        for pixel in out.rgba.chunks_mut(4) {
            let alpha = f64::from(pixel[3]) / 255.0;
            let laid = |x: u8| (f64::from(x) * alpha + 255.0 * (1.0 - alpha)).round() as u8;
            pixel.iter_mut().for_each(|x| *x = laid(*x));
            pixel[3] = 0xff;
        }
        out
    }

    /// Encodes the picture as PNG.
    ///
    /// # Errors
    /// Those of the encoder.
    pub fn png(&self) -> Result<Vec<u8>, EncodingError> {
        let mut bytes = Vec::new();
        let Resolution { width, height } = self.size;
        let mut encoder = Encoder::new(&mut bytes, width as u32, height as u32);
        encoder.set_color(ColorType::Rgba);
        encoder.set_depth(BitDepth::Eight);
        encoder.write_header()?.write_image_data(&self.rgba)?;
        Ok(bytes)
    }

    fn index(&self, [x, y]: [usize; 2]) -> Option<usize> {
        let Resolution { width, height } = self.size;
        (x < width && y < height).then_some(4 * (y * width + x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_reads_back() {
        let size = Resolution { width: 2, height: 1 };
        let picture = Picture { size, rgba: vec![1, 2, 3, 255, 4, 5, 6, 128] };
        let bytes = std::io::Cursor::new(picture.png().unwrap());
        let mut reader = png::Decoder::new(bytes).read_info().unwrap();
        let mut rgba = vec![0; 8];
        let info = reader.next_frame(&mut rgba).unwrap();
        assert_eq!((info.width, info.height, info.color_type), (2, 1, ColorType::Rgba));
        assert_eq!(rgba, picture.rgba);
    }

    #[test]
    fn pixels_beyond_the_picture_are_left_alone() {
        let mut picture = Picture::filled(2, 2, [0; 3]);
        picture.mix([2, 0], [255; 3], 1.0);
        picture.mix([1, 1], [200; 3], 0.5);
        assert_eq!((picture.colour([0, 1]), picture.colour([1, 1])), ([0; 3], [100; 3]));
    }
}
