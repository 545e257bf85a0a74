//! What a set of views holds.

use super::elements::Element;
use super::image::Image;
use sinew_runtime::kernel::EulerOrder;
use std::collections::BTreeMap;

/// Parameters by name: angles in degrees.
pub type Values = BTreeMap<String, f64>;

/// Views of one object, in one or several motions.
#[derive(Clone, Debug)]
pub struct ViewSet {
    /// Its name.
    pub name: String,
    /// Width and height of the pictures, pixels.
    pub size: [usize; 2],
    /// Layers, the hindmost first; one at least.
    pub layers: Vec<Layer>,
    /// Motions, each a map from parameters of its own to the same points.
    pub maps: Vec<Examples>,
}

/// A layer of an object.
#[derive(Clone, Debug, Default)]
pub struct Layer {
    /// Its name.
    pub name: String,
    /// Its points.
    pub points: Vec<usize>,
    /// Elements, by numbers of the set's points, the hindmost first where there is no depth; none of one whose pictures
    /// are bent as a whole.
    pub elements: Vec<Element>,
    /// The layer outside of which it is not seen.
    pub clip: Option<usize>,
}

impl Layer {
    /// Makes the layer of an object that has no others.
    pub fn whole(name: &str, point_len: usize, elements: Vec<Element>) -> Self {
        Self { name: name.to_owned(), points: (0..point_len).collect(), elements, clip: None }
    }
}

/// Views of one motion.
#[derive(Clone, Debug)]
pub struct Examples {
    /// Its name.
    pub name: String,
    /// What moves it.
    pub parameters: Vec<Parameter>,
    /// Views to learn from; one at least.
    pub train: Vec<View>,
    /// Views to measure with.
    pub test: Vec<View>,
}

/// What a motion depends on.
#[derive(Clone, Debug, PartialEq)]
pub enum Parameter {
    /// A number.
    Scalar(String),
    /// Angles in degrees about x, y and z, by name where they are given, which make one rotation: 359° is
    /// next to 1°.
    Rotation {
        /// Their names.
        angles: [Option<String>; 3],
        /// The order in which they turn; where none is said, that which predicts left-out views best.
        order: Option<EulerOrder>,
    },
}

/// An example.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The parameters.
    pub values: Values,
    /// K points in pixels, y down; none where nobody knows.
    pub points: Vec<Option<[f64; 2]>>,
    /// K: whether each is seen. One that is seen without a place was proposed in other views, and nobody knows.
    pub visible: Vec<bool>,
    /// K depths in pixels, growing away from the viewer; empty where there are none.
    pub depths: Vec<f64>,
    /// The picture of a key view.
    pub image: Option<Image>,
    /// L layers, each as it is in this view; empty of a set of one layer, whose picture is that of the view.
    pub layers: Vec<LayerView>,
}

/// A layer in a view.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayerView {
    /// Its picture; none of a layer that is not seen.
    pub image: Option<Image>,
    /// How opaque it is, from 0 to 1; none where nobody says.
    pub opacity: Option<f64>,
    /// What it is drawn over: layers of a lesser order; none where nobody says.
    pub order: Option<f64>,
}

impl ViewSet {
    /// Returns K.
    pub fn point_len(&self) -> usize {
        let first = self.maps.iter().find_map(|map| map.train.first());
        first.map_or(0, |view| view.points.len())
    }

    /// Says which training view a key view is.
    pub fn view_name(&self, (map, view): (usize, usize)) -> String {
        format!("{}, train view {view}", self.maps[map].name)
    }

    /// Returns how many elements its layers have.
    pub fn element_len(&self) -> usize {
        self.layers.iter().map(|layer| layer.elements.len()).sum()
    }

    /// Whether views have a depth for their points.
    pub fn has_depth(&self) -> bool {
        self.maps.iter().flat_map(|map| &map.train).any(|view| !view.depths.is_empty())
    }

    /// Lists the key views, those with a picture: the map and the training view of each.
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
    /// Returns L.
    pub fn layer_len(&self) -> usize {
        self.train.first().map_or(1, |view| view.layers.len().max(1))
    }
}

impl Parameter {
    /// Lists the names by which values are given.
    pub fn names(&self) -> Vec<&str> {
        match self {
            Self::Scalar(name) => vec![name],
            Self::Rotation { angles, .. } => angles.iter().flatten().map(String::as_str).collect(),
        }
    }
}

impl View {
    /// Whether it has a picture.
    pub fn is_key(&self) -> bool {
        match &self.layers[..] {
            [] => self.image.is_some(),
            layers => layers.iter().any(|layer| layer.image.is_some()),
        }
    }

    /// Returns its picture of a layer.
    pub fn picture(&self, layer: usize) -> Option<&Image> {
        match &self.layers[..] {
            [] => self.image.as_ref(),
            layers => layers.get(layer)?.image.as_ref(),
        }
    }

    /// Lists of each point whether it is seen; none where nobody knows.
    pub fn seen(&self) -> impl Iterator<Item = Option<bool>> {
        let points = self.visible.iter().zip(&self.points);
        points.map(|(seen, place)| (!seen || place.is_some()).then_some(*seen))
    }

    /// Returns the points, and the origin for those that nobody knows.
    pub fn known(&self) -> Vec<[f64; 2]> {
        self.points.iter().map(|point| point.unwrap_or_default()).collect()
    }
}
