//! Scenes: rigged characters and their clips, whichever format they come in.

mod clip;
mod error;
mod motion;
mod names;
mod played;
mod sampled;
mod sampling;
mod times;

pub(crate) use clip::RATE;
pub use clip::{Clip, RATES};
pub use error::SceneError;
pub(super) use motion::bound;
pub(crate) use motion::{Motion, MotionJoints};
pub use names::JointNames;
pub(crate) use names::mismatch;
pub(super) use names::told_apart;
pub(super) use played::{MovingJoints, Sample, samples};
pub(crate) use sampled::SampledScene;
pub(crate) use sampling::Sampling;
pub(crate) use times::EVEN;
