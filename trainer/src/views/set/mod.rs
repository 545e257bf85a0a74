//! Sets of views as a person writes them: parameters, points, visibility, pictures, elements.

mod data;
mod drawing;
mod elements;
mod json;
mod layers;
mod proposed;
mod read;

pub use data::{Element, Examples, Image, Layer, LayerView, Parameter, Values, View, ViewSet};
pub(in crate::views) use drawing::segment_distance;
pub use drawing::{JOINTS, read_drawing};
pub use elements::triangulated;
pub(in crate::views) use elements::{Covered, cropped, cross};
pub use json::as_json;
pub(in crate::views) use read::check_places;
pub use read::{read, read_instance};
