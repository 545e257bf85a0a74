//! Scenes: rigged characters and their clips, whichever format they come in.

mod clip;
mod error;
mod motion;
mod sampled;
mod sampling;
mod times;

pub(crate) use clip::RATE;
pub use clip::{Clip, RATES};
pub use error::SceneError;
pub(crate) use motion::Motion;
pub(crate) use sampled::SampledScene;
pub(crate) use sampling::Sampling;
pub(crate) use times::EVEN;
pub(super) use times::sample_times;
