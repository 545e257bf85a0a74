//! Pictures one after the other, as a GIF that plays again and again.

use super::picture::Picture;
use gif::{Encoder, EncodingError, Frame, Repeat};

/// How fast the encoder searches for 256 colours: 1 is best, 30 fastest.
const COLOUR_SPEED: i32 = 10;

/// A GIF that is being written.
pub struct Gif {
    hundredths: u16,
    encoder: Option<Encoder<Vec<u8>>>,
}

/// A picture that a GIF cannot take.
#[derive(Debug, thiserror::Error)]
pub enum GifError {
    /// Width or height is above 65535 pixels.
    #[error("pictures of {0} x {1} pixels, GIF has 65535 at most")]
    Size(usize, usize),
    /// The encoder refused it.
    #[error("cannot encode a GIF: {0}")]
    Encoding(#[from] EncodingError),
}

impl Gif {
    /// Begins a GIF that shows each picture for so many hundredths of a second.
    pub fn new(hundredths: u16) -> Self {
        Self { hundredths, encoder: None }
    }

    /// Adds a picture of straight alpha, on white.
    ///
    /// # Errors
    /// Every [`GifError`].
    pub fn add(&mut self, picture: &Picture) -> Result<(), GifError> {
        let [width, height] = [picture.size.width, picture.size.height];
        let [Ok(columns), Ok(rows)] = [width, height].map(u16::try_from) else {
            return Err(GifError::Size(width, height));
        };
        let mut rgba = picture.on_white().rgba;
        let frame = Frame::from_rgba_speed(columns, rows, &mut rgba, COLOUR_SPEED);
        let encoder = match self.encoder.take() {
            Some(encoder) => encoder,
            None => {
                let mut encoder = Encoder::new(Vec::new(), columns, rows, &[])?;
                encoder.set_repeat(Repeat::Infinite)?;
                encoder
            }
        };
        let encoder = self.encoder.insert(encoder);
        Ok(encoder.write_frame(&Frame { delay: self.hundredths, ..frame })?)
    }

    /// Returns the file's bytes; none without a picture.
    ///
    /// # Errors
    /// [`GifError::Encoding`].
    pub fn finish(self) -> Result<Vec<u8>, GifError> {
        let bytes = self.encoder.map(Encoder::into_inner).transpose()?;
        Ok(bytes.unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gif::{ColorOutput, DecodeOptions};

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
