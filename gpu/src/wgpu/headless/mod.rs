//! A device without a window or an engine: finds it, allocates, submits and waits.

mod device;
mod uploaded;

pub use device::{Device, devices};
