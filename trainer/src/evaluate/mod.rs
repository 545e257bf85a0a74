//! Measures a baked model: the f32 runtime on the file's bytes, compared with the examples, and baselines on the same
//! frames.

mod baselines;
mod character;
mod error;
mod evaluation;
mod measured;

pub use baselines::{Baselines, LBS, MeasuredBaseline, OWN_WEIGHTS};
pub use character::{
    Baseline, Character, SkinnedFrame, TrainingRecord, least_confident_joint, skin,
};
pub use error::EvaluateError;
pub use evaluation::{Evaluation, Frames, Region, evaluate};
pub use measured::{Confidence, Errors, Measured, MeasuredFrame, Millimetres, NOTHING};
