//! Layered pictures: OpenRaster and Photoshop files.

mod ora;
mod psd;
#[cfg(test)]
mod tests;
mod tree;

pub(crate) use tree::PaintedLayer;

use super::error::{FileError, FormatError, LayeredError};
use super::pixels::Pixels;
use std::fs::File;
use std::path::Path;

/// An open layered picture; its layers are decoded on demand.
pub(crate) struct LayeredPicture {
    /// Width and height.
    pub(crate) size: [usize; 2],
    /// All layers, outside their groups, the hindmost first.
    pub(crate) layers: Vec<PaintedLayer>,
    /// Paths of the groups.
    groups: Vec<String>,
    content: Content,
}

/// Whether a file has the ending of a layered picture.
pub(crate) fn is_layered(file: &Path) -> bool {
    let ending = file.extension().map(|ending| ending.to_ascii_lowercase());
    ending.is_some_and(|ending| ending == "ora" || ending == "psd")
}

impl LayeredPicture {
    /// Opens a file by its ending and reads its list of layers.
    ///
    /// # Errors
    /// [`LayeredError`], or the file cannot be read.
    pub(crate) fn open(path: &Path) -> Result<Self, FileError> {
        Self::opened(path).map_err(|error| FileError { file: path.to_owned(), error })
    }

    fn opened(path: &Path) -> Result<Self, FormatError> {
        let is_psd = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("psd"));
        let (content, size, nodes) = if is_psd {
            let bytes = std::fs::read(path).map_err(FormatError::Read)?;
            let (document, size, nodes) = psd::Document::read(bytes)?;
            (Content::Psd(document), size, nodes)
        } else {
            let file = File::open(path).map_err(FormatError::Read)?;
            let (archive, size, nodes) = ora::Archive::open(file)?;
            (Content::Ora(archive), size, nodes)
        };
        let (layers, groups) = tree::list_layers(nodes)?;
        Ok(Self { size, layers, groups, content })
    }

    /// Returns the index of a layer by its path, or by its name if only one layer has it.
    ///
    /// # Errors
    /// [`LayeredError::NoLayer`], [`LayeredError::Several`] and [`LayeredError::Group`].
    pub(crate) fn find(&self, name: &str) -> Result<usize, LayeredError> {
        if let Some(found) = self.layers.iter().position(|layer| layer.path == name) {
            return Ok(found);
        }
        let found: Vec<usize> =
            (0..self.layers.len()).filter(|&at| self.layers[at].name == name).collect();
        let paths = |layers: &mut dyn Iterator<Item = &PaintedLayer>| {
            layers.map(|layer| format!("\"{}\"", layer.path)).collect::<Vec<_>>().join(", ")
        };
        let name = name.to_owned();
        match found[..] {
            [only] => Ok(only),
            [] if self.groups.contains(&name) => Err(LayeredError::Group(name)),
            [] => {
                let found = paths(&mut self.layers.iter());
                Err(LayeredError::NoLayer { name, found })
            }
            _ => {
                let found = paths(&mut found.iter().map(|&at| &self.layers[at]));
                Err(LayeredError::Several { name, found })
            }
        }
    }

    /// Decodes a layer at the size of the whole picture, without its opacity and clipping.
    ///
    /// # Errors
    /// [`LayeredError::Blend`] and [`LayeredError::Picture`].
    pub(crate) fn picture(&self, layer: usize) -> Result<Pixels, LayeredError> {
        let own = &self.layers[layer];
        let name = || own.path.clone();
        if let Some(mode) = &own.blend {
            return Err(LayeredError::Blend { layer: name(), mode: mode.clone() });
        }
        let found = match &self.content {
            Content::Ora(archive) => archive.picture(own.source),
            Content::Psd(document) => document.picture(own.source),
        };
        let wrong = |what| LayeredError::Picture { layer: name(), what };
        let (pixels, corner) = found.map_err(wrong)?;
        let mut canvas = Pixels::empty(self.size);
        canvas.place(&pixels, corner);
        if let Content::Psd(document) = &self.content {
            for &record in own.groups.iter().chain([&own.source]) {
                document.mask(record, &mut canvas).map_err(wrong)?;
            }
        }
        Ok(canvas)
    }

    /// Draws all layers over each other.
    ///
    /// # Errors
    /// Those of [`Self::picture`].
    pub(crate) fn flattened(&self) -> Result<Pixels, LayeredError> {
        let [width, height] = self.size;
        let mut sum = vec![[0.0f32; 4]; width * height];
        let mut shapes: Vec<Vec<f32>> = vec![Vec::new(); self.layers.len()];
        // For each layer, the last layer that is clipped to it.
        let mut lasts = vec![0; self.layers.len()];
        for (number, layer) in self.layers.iter().enumerate() {
            layer.clip.into_iter().for_each(|base| lasts[base] = number);
        }
        let shown = self.layers.iter().enumerate().filter(|(_, own)| own.is_shown(&self.layers));
        for (number, layer) in shown {
            let picture = self.picture(number)?;
            let alphas = picture.rgba.chunks(4).map(|pixel| f32::from(pixel[3]) / 255.0);
            let mut shape: Vec<f32> = alphas.map(|alpha| layer.opacity as f32 * alpha).collect();
            if let Some(base) = layer.clip {
                shape.iter_mut().zip(&shapes[base]).for_each(|(own, base)| *own *= base);
                if lasts[base] == number {
                    shapes[base] = Vec::new();
                }
            }
            for ((sum, pixel), alpha) in sum.iter_mut().zip(picture.rgba.chunks(4)).zip(&shape) {
                for (channel, sum) in sum.iter_mut().enumerate() {
                    let own = if channel == 3 { 255.0 } else { f32::from(pixel[channel]) };
                    *sum = alpha * own + (1.0 - alpha) * *sum;
                }
            }
            if lasts[number] > number {
                shapes[number] = shape;
            }
        }
        let straight = |[r, g, b, a]: [f32; 4]| {
            let by = if a > 0.0 { 255.0 / a } else { 0.0 };
            [r * by, g * by, b * by, a].map(|x| x.round() as u8)
        };
        Ok(Pixels { size: self.size, rgba: sum.into_iter().flat_map(straight).collect() })
    }
}

enum Content {
    Ora(ora::Archive),
    Psd(psd::Document),
}
