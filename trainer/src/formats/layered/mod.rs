//! Layered pictures: OpenRaster and Photoshop files.

mod ora;
mod psd;
#[cfg(test)]
mod tests;
mod tree;

pub(crate) use tree::PaintedLayer;

use super::extension::extension;
use super::pixels::Pixels;
use crate::Error;
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
    matches!(extension(file).as_str(), "ora" | "psd")
}

impl LayeredPicture {
    /// Opens a file by its ending and reads its list of layers.
    ///
    /// # Errors
    /// The file cannot be read, is not a layered picture, has no layers, or is too large; or its list of layers cannot
    /// be represented.
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        Self::opened(path).map_err(|error| error.in_file(path))
    }

    fn opened(path: &Path) -> Result<Self, Error> {
        let (content, size, nodes) = if extension(path) == "psd" {
            let bytes = std::fs::read(path).map_err(Error::read)?;
            let (document, size, nodes) = psd::Document::read(bytes)?;
            (Content::Psd(document), size, nodes)
        } else {
            let file = File::open(path).map_err(Error::read)?;
            let (archive, size, nodes) = ora::Archive::open(file)?;
            (Content::Ora(archive), size, nodes)
        };
        let (layers, groups) = tree::list_layers(nodes)?;
        Ok(Self { size, layers, groups, content })
    }

    /// Returns the index of a layer by its path, or by its name if only one layer has it.
    ///
    /// # Errors
    /// No layer or several layers have the name, or it belongs to a group.
    pub(crate) fn find(&self, name: &str) -> Result<usize, Error> {
        if let Some(found) = self.layers.iter().position(|layer| layer.path == name) {
            return Ok(found);
        }
        let found: Vec<usize> =
            (0..self.layers.len()).filter(|&at| self.layers[at].name == name).collect();
        let paths = |layers: &mut dyn Iterator<Item = &PaintedLayer>| {
            layers.map(|layer| format!("\"{}\"", layer.path)).collect::<Vec<_>>().join(", ")
        };
        match found[..] {
            [only] => Ok(only),
            [] if self.groups.iter().any(|group| group == name) => {
                Err(Error::value(format!("\"{name}\" is a group: merge it, or name its layers")))
            }
            [] => {
                let found = paths(&mut self.layers.iter());
                Err(Error::missing(format!("has no layer \"{name}\": its layers are {found}")))
            }
            _ => {
                let found = paths(&mut found.iter().map(|&at| &self.layers[at]));
                Err(Error::value(format!("has several layers \"{name}\": write one of {found}")))
            }
        }
    }

    /// Decodes a layer at the size of the whole picture, without its opacity and clipping.
    ///
    /// # Errors
    /// The layer has a blend mode other than normal, or its picture cannot be read.
    pub(crate) fn picture(&self, layer: usize) -> Result<Pixels, Error> {
        let own = &self.layers[layer];
        let path = &own.path;
        if let Some(mode) = &own.blend {
            return Err(Error::unsupported(format!(
                "layer \"{path}\" has the blend mode {mode}, expected normal: merge it down"
            )));
        }
        let found = match &self.content {
            Content::Ora(archive) => archive.picture(own.source),
            Content::Psd(document) => document.picture(own.source),
        };
        let wrong = |what: String| Error::damaged(format!("layer \"{path}\": {what}"));
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
    pub(crate) fn flattened(&self) -> Result<Pixels, Error> {
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
