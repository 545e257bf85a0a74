//! Why views cannot be taken.

use crate::formats::{FileError, FormatError};
use std::path::PathBuf;

/// Views that cannot be taken; views, points and elements count from 0.
#[derive(Debug, thiserror::Error)]
pub enum SetError {
    /// The file cannot be read.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A picture in layers cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// It is no JSON of this shape.
    #[error("{0}")]
    Json(#[from] serde_json::Error),
    /// Something is not there.
    #[error("there are no {0}")]
    Empty(&'static str),
    /// A view has too few numbers of a kind, or too many.
    #[error("{view}: expected {expected} {what}, found {found}")]
    Length {
        /// The view.
        view: String,
        /// What is counted.
        what: &'static str,
        /// As many as the first view has points.
        expected: usize,
        /// As many as there are.
        found: usize,
    },
    /// A parameter is missing, or is no number.
    #[error("{view}: parameter \"{name}\" is {what}")]
    Parameter {
        /// The view.
        view: String,
        /// The parameter.
        name: String,
        /// What is wrong.
        what: &'static str,
    },
    /// A view has something that does not belong there.
    #[error("{view}: \"{name}\" {what}")]
    Field {
        /// The view.
        view: String,
        /// Its name in the file.
        name: String,
        /// What is wrong.
        what: String,
    },
    /// A point is not known, but said to be seen.
    #[error("{view}: point {point} is visible and has no place")]
    Unknown {
        /// The view.
        view: String,
        /// The point.
        point: usize,
    },
    /// Nobody says whether a point is seen that has a place, or is one of a view with a picture.
    #[error(
        "{view}: point {point}: \"visible\" is null, expected true or false where there is a place or a picture"
    )]
    Unsaid {
        /// The view.
        view: String,
        /// The point.
        point: usize,
    },
    /// A point is known in no view.
    #[error("point {point} has a place in no view of \"{map}\"")]
    Nowhere {
        /// The motion.
        map: String,
        /// The point.
        point: usize,
    },
    /// A picture cannot be read.
    #[error("{}: {what}", file.display())]
    Image {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// A picture is not as large as the set says.
    #[error("{}: expected {} x {} pixels, found {} x {}", file.display(), expected[0], expected[1], found[0], found[1])]
    ImageSize {
        /// The file.
        file: PathBuf,
        /// The set's width and height.
        expected: [usize; 2],
        /// The picture's.
        found: [usize; 2],
    },
    /// A layer cannot be taken.
    #[error("layer \"{layer}\": {what}")]
    Layer {
        /// Its name.
        layer: String,
        /// What is wrong.
        what: String,
    },
    /// A picture in layers is in a set that says nothing of layers.
    #[error(
        "{} has layers: write \"points\": \"auto\", or name the layers with their points under \"layers\"",
        file.display()
    )]
    Unnamed {
        /// The picture.
        file: PathBuf,
    },
    /// The set's points are neither names nor to be proposed.
    #[error(
        "\"points\" beside \"image_size\": expected \"auto\" or a list of names, found {found}"
    )]
    Points {
        /// The value that is there.
        found: String,
    },
    /// Points are to be proposed in a set with depths.
    #[error("proposed points have no depth: leave \"depth\" and the mesh out")]
    Depths,
    /// A point is of no layer.
    #[error("point {point} is in no layer")]
    NoLayer {
        /// The point.
        point: usize,
    },
    /// An element names a point that there is not, or one twice, or has fewer than three.
    #[error("element {element}: {what}")]
    Element {
        /// The element.
        element: usize,
        /// What is wrong.
        what: String,
    },
    /// An element, or a triangle of it, has no area in a key view in which it is seen.
    #[error(
        "element {element}: points {points:?} have no area in {view}: move one, mark one as not visible, or leave them out"
    )]
    NoArea {
        /// The element, by its place in the file.
        element: usize,
        /// Its points, or those of the triangle.
        points: Vec<usize>,
        /// The view.
        view: String,
    },
    /// A quad has a dent in a key view in which it is seen.
    #[error("element {element}: quad {points:?} is not convex in {view}: write {:?}, {:?} in its place", triangles[0], triangles[1])]
    Concave {
        /// The element, by its place in the file.
        element: usize,
        /// Its points.
        points: [usize; 4],
        /// The view.
        view: String,
        /// Triangles that cover it there.
        triangles: [[usize; 3]; 2],
    },
    /// Edges of a quad cross in a key view in which it is seen.
    #[error(
        "element {element}: edges of quad {points:?} cross in {view}: list its points in turn, or write two triangles in its place"
    )]
    Crossed {
        /// The element, by its place in the file.
        element: usize,
        /// Its points.
        points: [usize; 4],
        /// The view.
        view: String,
    },
    /// Points lie where no triangles can be made of them.
    #[error("the points of {view} cannot be triangulated: {what}")]
    Triangulation {
        /// The view.
        view: String,
        /// Why.
        what: String,
    },
    /// The mesh that gives depths does not have a point.
    #[error("point {point} is vertex {vertex} of the mesh, which has {vertices}")]
    Vertex {
        /// The point.
        point: usize,
        /// The vertex.
        vertex: usize,
        /// As many as there are.
        vertices: usize,
    },
}

impl SetError {
    /// Makes a [`SetError::Field`].
    pub(super) fn field(view: &str, name: &str, what: &str) -> Self {
        Self::Field { view: view.to_owned(), name: name.to_owned(), what: what.to_owned() }
    }

    /// Makes the error of a layer that no view shows.
    pub(super) fn never_shown(layer: &str) -> Self {
        let what = "no view has a picture of it: name one, or leave it out".to_owned();
        Self::Layer { layer: layer.to_owned(), what }
    }
}
