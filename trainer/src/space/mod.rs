//! Axes, handedness and unit: what is said of a space, and the way from one to another.

pub(crate) mod axes;
mod conversion;
mod wish;

pub use conversion::Conversion;
pub(crate) use wish::UNITS;
pub use wish::{SpaceError, SpaceWish};
