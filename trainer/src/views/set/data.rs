//! The data of a set of views: layers, motions, views, elements and pictures.

use crate::formats::layered::{LayeredPicture, is_layered};
use crate::formats::pixels::{Pixels, png_size, read_png};
use crate::page::camera::Resolution;
use crate::page::picture::Picture;
use crate::{Error, ErrorKind};
use sinew_runtime::kernel::EulerOrder;
pub use sinew_runtime::views::Element;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

/// Values of parameters by name. Angles are in degrees.
pub type Values = BTreeMap<String, f64>;

/// Views of one object, in one or several motions.
#[derive(Clone, Debug)]
pub struct ViewSet {
    /// Name of the object.
    pub name: String,
    /// Width and height of the pictures, pixels.
    pub size: [usize; 2],
    /// Layers, the hindmost first; at least one.
    pub layers: Vec<Layer>,
    /// Motions, each with its own parameters and the same points.
    pub maps: Vec<Examples>,
}

/// A layer of an object.
#[derive(Clone, Debug, Default)]
pub struct Layer {
    /// Name of the layer.
    pub name: String,
    /// Indices of the points of the layer.
    pub points: Vec<usize>,
    /// Elements, with indices of the set's points as vertices; without depth the hindmost is first. Empty if the
    /// pictures are warped as a whole.
    pub elements: Vec<Element>,
    /// Index of the layer that clips this layer.
    pub clip: Option<usize>,
}

impl Layer {
    /// Makes the only layer of an object.
    pub fn whole(name: &str, point_len: usize, elements: Vec<Element>) -> Self {
        Self { name: name.to_owned(), points: (0..point_len).collect(), elements, clip: None }
    }
}

/// Views of one motion.
#[derive(Clone, Debug)]
pub struct Examples {
    /// Name of the motion.
    pub name: String,
    /// Parameters of the motion.
    pub parameters: Vec<Parameter>,
    /// Training views; at least one.
    pub train: Vec<View>,
    /// Test views.
    pub test: Vec<View>,
}

/// A parameter of a motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Parameter {
    /// A number.
    Scalar(String),
    /// One rotation by angles about x, y and z in degrees. 359° is next to 1°.
    Rotation {
        /// Names of the angles; `None` for unused angles.
        angles: [Option<String>; 3],
        /// Order of the angles. If `None`, the fit chooses the order that predicts left-out views best.
        order: Option<EulerOrder>,
    },
}

/// A view.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// Values of the parameters.
    pub values: Values,
    /// The K points in pixels, y down; `None` if unknown.
    pub points: Vec<Option<[f64; 2]>>,
    /// Whether each of the K points is visible. A visible point without a position was proposed in other views, and its
    /// visibility is unknown.
    pub visible: Vec<bool>,
    /// The K depths in pixels, growing away from the viewer; empty without depths.
    pub depths: Vec<f64>,
    /// Picture of a key view.
    pub image: Option<Image>,
    /// The L layers in this view. Empty in a set of one layer, where the view has the picture.
    pub layers: Vec<LayerView>,
}

/// A layer in a view.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayerView {
    /// Picture of the layer; `None` if the layer is hidden.
    pub image: Option<Image>,
    /// Opacity from 0 to 1; `None` if unknown.
    pub opacity: Option<f64>,
    /// Order: the layer is drawn over layers of smaller order. `None` if unknown.
    pub order: Option<f64>,
}

impl ViewSet {
    /// Returns the number of points, K.
    pub fn point_len(&self) -> usize {
        let first = self.maps.iter().find_map(|map| map.train.first());
        first.map_or(0, |view| view.points.len())
    }

    /// Returns a training view by its motion and index.
    pub fn view(&self, (map, view): (usize, usize)) -> &View {
        &self.maps[map].train[view]
    }

    /// Names a training view by its motion and index.
    pub fn view_name(&self, (map, view): (usize, usize)) -> String {
        format!("{}, train view {view}", self.maps[map].name)
    }

    /// Returns the number of elements of all layers.
    pub fn element_len(&self) -> usize {
        self.layers.iter().map(|layer| layer.elements.len()).sum()
    }

    /// Whether views have depths.
    pub fn has_depth(&self) -> bool {
        self.maps.iter().flat_map(|map| &map.train).any(|view| !view.depths.is_empty())
    }

    /// Lists the key views, which have a picture: indices of the motion and the training view.
    pub fn key_views(&self) -> Vec<(usize, usize)> {
        let of = |(map, examples): (usize, &Examples)| {
            let views = examples.train.iter().enumerate();
            let keys = views.filter(|(_, view)| view.is_key());
            keys.map(move |(view, _)| (map, view)).collect::<Vec<_>>()
        };
        self.maps.iter().enumerate().flat_map(of).collect()
    }
}

impl Examples {
    /// Returns the number of layers, L.
    pub fn layer_len(&self) -> usize {
        self.train.first().map_or(1, |view| view.layers.len().max(1))
    }
}

impl Parameter {
    /// Lists the names of the values of the parameter.
    pub fn names(&self) -> Vec<&str> {
        match self {
            Self::Scalar(name) => vec![name],
            Self::Rotation { angles, .. } => angles.iter().flatten().map(String::as_str).collect(),
        }
    }
}

impl View {
    /// Makes a view whose points are all visible.
    pub fn of_points(values: Values, points: Vec<[f64; 2]>) -> Self {
        let visible = vec![true; points.len()];
        Self { values, visible, points: points.into_iter().map(Some).collect(), ..Self::default() }
    }

    /// Whether the view has a picture.
    pub fn is_key(&self) -> bool {
        match &self.layers[..] {
            [] => self.image.is_some(),
            layers => layers.iter().any(|layer| layer.image.is_some()),
        }
    }

    /// Returns the picture of a layer.
    pub fn picture(&self, layer: usize) -> Option<&Image> {
        match &self.layers[..] {
            [] => self.image.as_ref(),
            layers => layers.get(layer)?.image.as_ref(),
        }
    }

    /// Lists whether each point is visible; `None` if unknown.
    pub fn seen(&self) -> impl Iterator<Item = Option<bool>> {
        let points = self.visible.iter().zip(&self.points);
        points.map(|(seen, place)| (!seen || place.is_some()).then_some(*seen))
    }

    /// Returns the points, with the origin for unknown points.
    pub fn known(&self) -> Vec<[f64; 2]> {
        self.points.iter().map(|point| point.unwrap_or_default()).collect()
    }
}

/// Makes elements of a polygon. A polygon with more than four corners becomes a fan of triangles around the first
/// corner.
///
/// # Errors
/// [`ErrorKind::Value`]: the polygon has fewer than three points, an unknown point, or a point twice.
pub(super) fn elements_of(
    element: usize,
    polygon: &[usize],
    points: usize,
) -> Result<Vec<Element>, Error> {
    let wrong = |what: String| Error::value(format!("element {element}: {what}"));
    if let Some(point) = polygon.iter().find(|point| **point >= points) {
        return Err(wrong(format!("point {point}, of {points}")));
    }
    let twice = (1..polygon.len()).find(|&at| polygon[..at].contains(&polygon[at]));
    if let Some(at) = twice {
        return Err(wrong(format!("point {} is there twice", polygon[at])));
    }
    match *polygon {
        [a, b, c] => Ok(vec![Element::Triangle([a, b, c])]),
        [a, b, c, d] => Ok(vec![Element::Quad([a, b, c, d])]),
        [first, _, _, _, _, ..] => {
            let fan = polygon[1..].windows(2).map(|pair| [first, pair[0], pair[1]]);
            Ok(fan.map(Element::Triangle).collect())
        }
        _ => Err(wrong(format!("expected 3 points or more, found {}", polygon.len()))),
    }
}

/// A picture file, with an optional mask or layer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// The picture: PNG, OpenRaster or Photoshop.
    pub file: PathBuf,
    /// A mask: black pixels are outside the object.
    pub mask: Option<PathBuf>,
    /// Name of the layer in a picture in layers; `None` for the whole picture.
    pub layer: Option<String>,
}

impl Image {
    /// Names a picture without a mask.
    pub fn of_file(file: PathBuf) -> Self {
        Self { file, mask: None, layer: None }
    }

    /// Names the picture of a layer. In a picture in layers the layer has the same name.
    pub fn of_layer(file: PathBuf, layer: &str) -> Self {
        let layer = is_layered(&file).then(|| layer.to_owned());
        Self { layer, ..Self::of_file(file) }
    }

    /// Loads the picture in its own size.
    ///
    /// # Errors
    /// The picture or the mask cannot be read, is damaged, or has no such layer; the mask has another size.
    pub fn load_any(&self) -> Result<Picture, Error> {
        self.load(picture_size(&self.file)?)
    }

    /// Loads the picture. Pixels outside the mask are cleared.
    ///
    /// - `expected`: width and height, pixels.
    ///
    /// # Errors
    /// The picture or the mask cannot be read, is damaged, has no such layer, or has another size.
    pub fn load(&self, expected: [usize; 2]) -> Result<Picture, Error> {
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

/// Returns the width and height of a picture, pixels.
///
/// # Errors
/// The picture cannot be read, or is damaged.
pub(super) fn picture_size(file: &Path) -> Result<[usize; 2], Error> {
    if is_layered(file) {
        return Ok(LayeredPicture::open(file)?.size);
    }
    png_size(opened(file)?).map_err(|what| Error::damaged(what).in_file(file))
}

fn decoded(file: &Path, layer: Option<&str>, expected: [usize; 2]) -> Result<Picture, Error> {
    let check = |found: [usize; 2]| {
        if found == expected {
            return Ok(());
        }
        let ([width, height], [own_width, own_height]) = (expected, found);
        let text = format!("expected {width} x {height} pixels, found {own_width} x {own_height}");
        Err(Error::mismatch(text).in_file(file))
    };
    let Pixels { size: [width, height], rgba } = if is_layered(file) {
        let picture = LayeredPicture::open(file)?;
        check(picture.size)?;
        let found = match layer {
            Some(name) => picture.find(name).and_then(|layer| picture.picture(layer)),
            None => picture.flattened(),
        };
        found.map_err(|error| error.in_file(file))?
    } else {
        check(picture_size(file)?)?;
        read_png(opened(file)?).map_err(|what| Error::damaged(what).in_file(file))?
    };
    Ok(Picture { size: Resolution { width, height }, rgba })
}

fn opened(file: &Path) -> Result<BufReader<File>, Error> {
    let wrong = |error: io::Error| {
        Error::new(ErrorKind::Read, error.to_string()).caused_by(error).in_file(file)
    };
    Ok(BufReader::new(File::open(file).map_err(wrong)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_become_triangles_about_their_first_corner() {
        let found = elements_of(0, &[5, 1, 2, 3, 4], 6).unwrap();
        let expected = [[5, 1, 2], [5, 2, 3], [5, 3, 4]].map(Element::Triangle);
        assert_eq!(found, expected);
        assert_eq!(elements_of(0, &[3, 2, 1, 0], 4).unwrap().len(), 1);
    }

    #[test]
    fn points_that_make_no_element_are_named() {
        for (polygon, what) in [
            (&[0, 1][..], "expected 3 points or more, found 2"),
            (&[0, 1, 7], "point 7, of 4"),
            (&[0, 1, 2, 1], "point 1 is there twice"),
        ] {
            let refused = elements_of(9, polygon, 4).unwrap_err();
            assert_eq!(refused.to_string(), format!("element 9: {what}"));
        }
    }
}
