//! Axes, handedness and unit: what is said of a space, and the way from one to another.

pub(crate) mod axes;
mod conversion;
mod millimetres;
mod request;

pub use conversion::Conversion;
pub use millimetres::{beside, millimetres, written};
pub(crate) use request::{SCALES, UNITS};
pub use request::{SpaceError, SpaceRequest};
