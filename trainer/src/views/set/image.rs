//! Pictures of key views.

use super::error::SetError;
use crate::formats::FileError;
use crate::formats::layered::{LayeredPicture, is_layered};
use crate::formats::pixels::{Pixels, png_size, read_png};
use crate::page::camera::Resolution;
use crate::page::picture::Picture;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// A picture, and what of it is the object.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// The picture: PNG, OpenRaster or Photoshop.
    pub file: PathBuf,
    /// A picture whose black is not the object.
    pub mask: Option<PathBuf>,
    /// The layer of a picture in layers; `None` for the whole picture.
    pub layer: Option<String>,
}

impl Image {
    /// Names a picture without a mask.
    pub fn of_file(file: PathBuf) -> Self {
        Self { file, mask: None, layer: None }
    }

    /// Names the picture of a layer: a picture in layers has it by the layer's name.
    pub fn of_layer(file: PathBuf, layer: &str) -> Self {
        let layer = is_layered(&file).then(|| layer.to_owned());
        Self { layer, ..Self::of_file(file) }
    }

    /// Loads the picture, whatever its size.
    ///
    /// # Errors
    /// [`SetError::Image`] and [`SetError::File`], and [`SetError::ImageSize`] of its mask.
    pub fn load_any(&self) -> Result<Picture, SetError> {
        self.load(size(&self.file)?)
    }

    /// Loads the picture; beyond its mask nothing is covered.
    ///
    /// # Errors
    /// [`SetError::Image`], [`SetError::File`] and [`SetError::ImageSize`].
    pub fn load(&self, expected: [usize; 2]) -> Result<Picture, SetError> {
        let mut picture = decoded(&self.file, self.layer.as_deref(), expected)?;
        if let Some(mask) = &self.mask {
            let mask = decoded(mask, None, expected)?;
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
/// [`SetError::Image`] and [`SetError::File`].
pub(super) fn size(file: &Path) -> Result<[usize; 2], SetError> {
    if is_layered(file) {
        return Ok(LayeredPicture::open(file)?.size);
    }
    png_size(opened(file)?).map_err(|what| wrong(file, what))
}

fn decoded(file: &Path, layer: Option<&str>, expected: [usize; 2]) -> Result<Picture, SetError> {
    let check = |found: [usize; 2]| match found == expected {
        true => Ok(()),
        false => Err(SetError::ImageSize { file: file.to_owned(), expected, found }),
    };
    let Pixels { size: [width, height], rgba } = if is_layered(file) {
        let picture = LayeredPicture::open(file)?;
        check(picture.size)?;
        let found = match layer {
            Some(name) => picture.find(name).and_then(|layer| picture.picture(layer)),
            None => picture.flattened(),
        };
        found.map_err(|error| FileError { file: file.to_owned(), error: error.into() })?
    } else {
        check(size(file)?)?;
        read_png(opened(file)?).map_err(|what| wrong(file, what))?
    };
    Ok(Picture { size: Resolution { width, height }, rgba })
}

fn opened(file: &Path) -> Result<BufReader<File>, SetError> {
    let opened = File::open(file).map_err(|error| wrong(file, error.to_string()))?;
    Ok(BufReader::new(opened))
}

fn wrong(file: &Path, what: String) -> SetError {
    SetError::Image { file: file.to_owned(), what }
}
