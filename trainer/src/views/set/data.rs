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
    /// Elements, the hindmost first where there is no depth.
    pub elements: Vec<Element>,
    /// Motions, each a map from parameters of its own to the same points.
    pub maps: Vec<Examples>,
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
    /// K: whether each is seen.
    pub visible: Vec<bool>,
    /// K depths in pixels, growing away from the viewer; empty where there are none.
    pub depths: Vec<f64>,
    /// The picture of a key view.
    pub image: Option<Image>,
}

impl ViewSet {
    /// Returns K.
    pub fn point_len(&self) -> usize {
        let first = self.maps.iter().find_map(|map| map.train.first());
        first.map_or(0, |view| view.points.len())
    }

    /// Lists the key views, those with a picture: the map and the training view of each.
    pub fn key_views(&self) -> Vec<(usize, usize)> {
        let of = |(map, examples): (usize, &Examples)| {
            let views = examples.train.iter().enumerate();
            let keys = views.filter(|(_, view)| view.image.is_some());
            keys.map(move |(view, _)| (map, view)).collect::<Vec<_>>()
        };
        self.maps.iter().enumerate().flat_map(of).collect()
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
    /// Returns the points, and the origin for those that nobody knows.
    pub fn known(&self) -> Vec<[f64; 2]> {
        self.points.iter().map(|point| point.unwrap_or_default()).collect()
    }
}
