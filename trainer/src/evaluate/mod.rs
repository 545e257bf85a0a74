//! Measures a baked model: the f32 runtime on the file's bytes against the examples, and baselines
//! beside it.

mod baselines;
mod character;
mod error;
mod evaluation;
mod measured;
mod skin;
mod told;

pub use baselines::{Baselines, LBS, MeasuredBaseline, OWN_WEIGHTS};
pub use character::Character;
pub use error::EvaluateError;
pub use evaluation::{Evaluation, Frames, Region, evaluate};
pub use measured::{Confidence, Errors, Measured, MeasuredFrame, Millimetres, NOTHING, largest};
pub use skin::{Baseline, SkinnedFrame, most_doubting, skin};
pub use told::Told;
