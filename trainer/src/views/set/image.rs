//! Pictures of key views.

use super::error::SetError;
use crate::page::camera::Resolution;
use crate::page::picture::Picture;
use png::{ColorType, Decoder, Transformations};
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// A picture, and what of it is the object.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// The picture, PNG.
    pub file: PathBuf,
    /// A picture whose black is not the object.
    pub mask: Option<PathBuf>,
}

impl Image {
    /// Loads the picture, whatever its size.
    ///
    /// # Errors
    /// [`SetError::Image`], and [`SetError::ImageSize`] of its mask.
    pub fn load_any(&self) -> Result<Picture, SetError> {
        self.load(size(&self.file)?)
    }

    /// Loads the picture; beyond its mask nothing is covered.
    ///
    /// # Errors
    /// [`SetError::Image`] and [`SetError::ImageSize`].
    pub fn load(&self, expected: [usize; 2]) -> Result<Picture, SetError> {
        let mut picture = decoded(&self.file, expected)?;
        if let Some(mask) = &self.mask {
            let mask = decoded(mask, expected)?;
            for (pixel, mask) in picture.rgba.chunks_mut(4).zip(mask.rgba.chunks(4)) {
                if mask[0] < 0x80 || mask[3] == 0 {
                    pixel.fill(0);
                }
            }
        }
        Ok(picture)
    }
}

/// Returns the width and height of a picture.
///
/// # Errors
/// [`SetError::Image`].
pub(super) fn size(file: &Path) -> Result<[usize; 2], SetError> {
    let opened = File::open(file).map_err(|error| wrong(file, &error))?;
    let reader = Decoder::new(BufReader::new(opened)).read_info().map_err(|e| wrong(file, &e))?;
    Ok([reader.info().width as usize, reader.info().height as usize])
}

fn decoded(file: &Path, expected: [usize; 2]) -> Result<Picture, SetError> {
    let found = size(file)?;
    if found != expected {
        return Err(SetError::ImageSize { file: file.to_owned(), expected, found });
    }
    let opened = File::open(file).map_err(|error| wrong(file, &error))?;
    let mut decoder = Decoder::new(BufReader::new(opened));
    decoder.set_transformations(Transformations::normalize_to_color8() | Transformations::ALPHA);
    let mut reader = decoder.read_info().map_err(|error| wrong(file, &error))?;
    let len = reader.output_buffer_size().ok_or_else(|| wrong(file, &"it is too large"))?;
    let mut bytes = vec![0; len];
    let frame = reader.next_frame(&mut bytes).map_err(|error| wrong(file, &error))?;
    bytes.truncate(frame.buffer_size());
    let rgba = match frame.color_type {
        ColorType::Rgba => bytes,
        ColorType::GrayscaleAlpha => {
            let (pixels, _) = bytes.as_chunks::<2>();
            pixels.iter().flat_map(|[grey, alpha]| [*grey, *grey, *grey, *alpha]).collect()
        }
        other => return Err(wrong(file, &format!("{other:?} is not read"))),
    };
    let size = Resolution { width: expected[0], height: expected[1] };
    Ok(Picture { size, rgba })
}

fn wrong(file: &Path, what: &dyn std::fmt::Display) -> SetError {
    SetError::Image { file: file.to_owned(), what: what.to_string() }
}
