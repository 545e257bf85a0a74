//! Views as a person writes them: parameters, points, what is visible, pictures, elements.

mod data;
mod depth;
mod drawing;
mod elements;
mod error;
mod image;
mod joined;
mod json;
mod layers;
mod lottie;
mod painted;
mod proposed;
mod silhouette;
mod write;

pub use data::{Examples, Layer, LayerView, Parameter, Values, View, ViewSet};
pub use drawing::read_drawing;
pub use elements::Element;
pub use error::SetError;
pub use image::Image;
pub use joined::triangulated;
pub use json::{read, read_instance};
pub use lottie::{AnimatedPath, read_lottie};
pub use write::as_json;
