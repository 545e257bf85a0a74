//! Pictures of pixels, and GIFs made of them.

use super::camera::Resolution;
use super::colour::Colour;
use crate::{Error, ErrorKind};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gif::{Frame, Repeat};
use png::{BitDepth, ColorType, EncodingError};
use std::error::Error as StdError;

/// Speed of the encoder's search for 256 colours: 1 is best, 30 fastest.
const COLOUR_SPEED: i32 = 10;

/// Pixels from the upper left, row by row: red, green, blue and alpha.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width and height, in pixels.
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

    /// Returns the colour of a pixel; black outside the picture.
    pub fn colour(&self, at: [usize; 2]) -> Colour {
        let pixel = self.index(at).map(|index| [0, 1, 2].map(|c| self.rgba[index + c]));
        pixel.unwrap_or_default()
    }

    /// Sets a pixel's colour.
    pub fn set(&mut self, at: [usize; 2], colour: Colour) {
        self.mix(at, colour, 1.0);
    }

    /// Mixes a share of a colour into a pixel; does nothing outside the picture.
    pub fn mix(&mut self, at: [usize; 2], colour: Colour, share: f64) {
        let Some(index) = self.index(at) else { return };
        for (byte, colour) in self.rgba[index..].iter_mut().zip(colour) {
            *byte = (f64::from(*byte) * (1.0 - share) + f64::from(colour) * share).round() as u8;
        }
    }

    /// Blends the picture onto white; its alpha is straight, not premultiplied.
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
    /// The picture has no pixels, or the encoder fails.
    pub fn png(&self) -> Result<Vec<u8>, Error> {
        self.encoded().map_err(|error| failed("picture", error))
    }

    /// Returns the picture as PNG in a data URI.
    ///
    /// # Errors
    /// Those of [`Picture::png`].
    pub(super) fn data_uri(&self) -> Result<String, Error> {
        Ok(format!("data:image/png;base64,{}", STANDARD.encode(self.png()?)))
    }

    fn encoded(&self) -> Result<Vec<u8>, EncodingError> {
        let mut bytes = Vec::new();
        let Resolution { width, height } = self.size;
        let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
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

/// A GIF under construction; it plays in a loop.
pub struct Gif {
    hundredths: u16,
    encoder: Option<gif::Encoder<Vec<u8>>>,
}

impl Gif {
    /// Begins a GIF that shows each picture for `hundredths` of a second.
    pub fn new(hundredths: u16) -> Self {
        Self { hundredths, encoder: None }
    }

    /// Adds a picture, blended onto white.
    ///
    /// # Errors
    /// - [`ErrorKind::Limit`]: width or height is above 65535 pixels.
    /// - [`ErrorKind::Write`]: the encoder fails.
    pub fn add(&mut self, picture: &Picture) -> Result<(), Error> {
        let [width, height] = [picture.size.width, picture.size.height];
        let [Ok(columns), Ok(rows)] = [width, height].map(u16::try_from) else {
            return Err(Error::limit(format!(
                "pictures of {width} x {height} pixels, GIF has 65535 at most"
            )));
        };
        let mut rgba = picture.on_white().rgba;
        let frame = Frame::from_rgba_speed(columns, rows, &mut rgba, COLOUR_SPEED);
        let failed = |error| failed("GIF", error);
        let encoder = match self.encoder.take() {
            Some(encoder) => encoder,
            None => {
                let encoder = gif::Encoder::new(Vec::new(), columns, rows, &[]);
                let mut encoder = encoder.map_err(failed)?;
                encoder.set_repeat(Repeat::Infinite).map_err(failed)?;
                encoder
            }
        };
        let encoder = self.encoder.insert(encoder);
        encoder.write_frame(&Frame { delay: self.hundredths, ..frame }).map_err(failed)
    }

    /// Returns the bytes of the file; empty if no picture was added.
    ///
    /// # Errors
    /// [`ErrorKind::Write`]: the encoder fails.
    pub fn finish(self) -> Result<Vec<u8>, Error> {
        let bytes = self.encoder.map(gif::Encoder::into_inner).transpose();
        Ok(bytes.map_err(|error| failed("GIF", error))?.unwrap_or_default())
    }
}

fn failed(what: &str, error: impl StdError + Send + Sync + 'static) -> Error {
    Error::new(ErrorKind::Write, format!("cannot encode a {what}: {error}")).caused_by(error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use gif::{ColorOutput, DecodeOptions};

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
    fn pixels_outside_the_picture_are_ignored() {
        let mut picture = Picture::filled(2, 2, [0; 3]);
        picture.mix([2, 0], [255; 3], 1.0);
        picture.mix([1, 1], [200; 3], 0.5);
        assert_eq!((picture.colour([0, 1]), picture.colour([1, 1])), ([0; 3], [100; 3]));
    }

    #[test]
    fn a_gif_has_its_pictures_and_their_time() {
        let mut made = Gif::new(7);
        for colour in [[200, 10, 20], [10, 200, 20]] {
            made.add(&Picture::filled(3, 2, colour)).unwrap();
        }
        let bytes = made.finish().unwrap();
        let mut options = DecodeOptions::new();
        options.set_color_output(ColorOutput::RGBA);
        let mut read = options.read_info(&bytes[..]).unwrap();
        for colour in [[200, 10, 20, 255], [10, 200, 20, 255]] {
            let frame = read.read_next_frame().unwrap().unwrap();
            assert_eq!((frame.width, frame.height, frame.delay), (3, 2, 7));
            assert_eq!(frame.buffer[..4], colour);
        }
        assert!(read.read_next_frame().unwrap().is_none());
    }

    #[test]
    fn a_picture_that_is_too_wide_is_refused() {
        let refused = Gif::new(4).add(&Picture::filled(70_000, 1, [0; 3]));
        assert_eq!(
            refused.unwrap_err().to_string(),
            "pictures of 70000 x 1 pixels, GIF has 65535 at most"
        );
    }
}
