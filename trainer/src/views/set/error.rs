//! Errors of sets of views.

use crate::formats::{FileError, FormatError};
use std::path::PathBuf;

/// Reasons why a set of views is invalid. Views, points and elements count from 0.
#[derive(Debug, thiserror::Error)]
pub enum SetError {
    /// The file cannot be read.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A picture in layers cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is not JSON of this shape.
    #[error("{0}")]
    Json(#[from] serde_json::Error),
    /// Something is missing.
    #[error("there are no {0}")]
    Empty(&'static str),
    /// A view has the wrong number of values of a kind.
    #[error("{view}: expected {expected} {what}, found {found}")]
    Length {
        /// Name of the view.
        view: String,
        /// Kind of the values.
        what: &'static str,
        /// Number of points of the first view.
        expected: usize,
        /// Number of values.
        found: usize,
    },
    /// A parameter is missing, or is not a number.
    #[error("{view}: parameter \"{name}\" is {what}")]
    Parameter {
        /// Name of the view.
        view: String,
        /// Name of the parameter.
        name: String,
        /// Fault.
        what: &'static str,
    },
    /// A view has an unknown or misplaced field.
    #[error("{view}: \"{name}\" {what}")]
    Field {
        /// Name of the view.
        view: String,
        /// Name of the field in the file.
        name: String,
        /// Fault.
        what: String,
    },
    /// A point is marked as visible, but has no position.
    #[error("{view}: point {point} is visible and has no place")]
    Unknown {
        /// Name of the view.
        view: String,
        /// Index of the point.
        point: usize,
    },
    /// The visibility of a point is null, although the point has a position or the view has a picture.
    #[error(
        "{view}: point {point}: \"visible\" is null, expected true or false where there is a place or a picture"
    )]
    NullVisibility {
        /// Name of the view.
        view: String,
        /// Index of the point.
        point: usize,
    },
    /// A point has no position in any view.
    #[error("point {point} has a place in no view of \"{map}\"")]
    Nowhere {
        /// Name of the motion.
        map: String,
        /// Index of the point.
        point: usize,
    },
    /// A picture cannot be read.
    #[error("{}: {what}", file.display())]
    Image {
        /// File of the picture.
        file: PathBuf,
        /// Fault.
        what: String,
    },
    /// A picture has another size than the set.
    #[error("{}: expected {} x {} pixels, found {} x {}", file.display(), expected[0], expected[1], found[0], found[1])]
    ImageSize {
        /// File of the picture.
        file: PathBuf,
        /// Width and height of the set, pixels.
        expected: [usize; 2],
        /// Width and height of the picture, pixels.
        found: [usize; 2],
    },
    /// A layer is invalid.
    #[error("layer \"{layer}\": {what}")]
    Layer {
        /// Name of the layer.
        layer: String,
        /// Fault.
        what: String,
    },
    /// A picture has layers, but the set does not name layers.
    #[error(
        "{} has layers: write \"points\": \"auto\", or name the layers with their points under \"layers\"",
        file.display()
    )]
    Unnamed {
        /// File of the picture.
        file: PathBuf,
    },
    /// The value of `points` is neither a list of names nor `"auto"`.
    #[error(
        "\"points\" beside \"image_size\": expected \"auto\" or a list of names, found {found}"
    )]
    Points {
        /// The value.
        found: String,
    },
    /// Points cannot be proposed in a set with depths.
    #[error("proposed points have no depth: leave \"depth\" and the mesh out")]
    Depths,
    /// A point is in no layer.
    #[error("point {point} is in no layer")]
    NoLayer {
        /// Index of the point.
        point: usize,
    },
    /// An element has an unknown point, a point twice, or fewer than three points.
    #[error("element {element}: {what}")]
    Element {
        /// Index of the element.
        element: usize,
        /// Fault.
        what: String,
    },
    /// An element, or one of its triangles, has no area in a key view that shows all its points.
    #[error(
        "element {element}: points {points:?} have no area in {view}: move one, mark one as not visible, or leave them out"
    )]
    NoArea {
        /// Index of the element in the file.
        element: usize,
        /// Points of the element, or of the triangle.
        points: Vec<usize>,
        /// Name of the view.
        view: String,
    },
    /// A quad is not convex in a key view that shows all its points.
    #[error("element {element}: quad {points:?} is not convex in {view}: write {:?}, {:?} in its place", triangles[0], triangles[1])]
    Concave {
        /// Index of the element in the file.
        element: usize,
        /// Points of the quad.
        points: [usize; 4],
        /// Name of the view.
        view: String,
        /// Two triangles that cover the quad in the view.
        triangles: [[usize; 3]; 2],
    },
    /// Edges of a quad cross in a key view that shows all its points.
    #[error(
        "element {element}: edges of quad {points:?} cross in {view}: list its points in turn, or write two triangles in its place"
    )]
    Crossed {
        /// Index of the element in the file.
        element: usize,
        /// Points of the quad.
        points: [usize; 4],
        /// Name of the view.
        view: String,
    },
    /// The points cannot be triangulated.
    #[error("the points of {view} cannot be triangulated: {what}")]
    Triangulation {
        /// Name of the view.
        view: String,
        /// Cause.
        what: String,
    },
    /// A point refers to a vertex that the mesh for depths does not have.
    #[error("point {point} is vertex {vertex} of the mesh, which has {vertices}")]
    Vertex {
        /// Index of the point.
        point: usize,
        /// Index of the vertex.
        vertex: usize,
        /// Number of vertices of the mesh.
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
