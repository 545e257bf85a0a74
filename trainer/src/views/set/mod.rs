//! Views as a person writes them: parameters, points, what is visible, pictures, elements.

mod data;
mod depth;
mod elements;
mod error;
mod json;
mod lottie;

pub use data::{Examples, Parameter, Values, View, ViewSet};
pub use depth::{depths, project};
pub use elements::{Element, check_elements, triangulated};
pub use error::SetError;
pub use json::{read, read_points};
pub use lottie::{AnimatedPath, read_lottie};
