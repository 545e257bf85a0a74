//! Measures a baked model: the f32 runtime on the file's bytes, compared with the examples, and baselines on the same
//! frames.

mod character;
mod evaluation;
mod measured;

pub use character::{
    Baseline, Character, SkinnedFrame, TrainingRecord, least_confident_joint, skin,
};
pub use evaluation::{Evaluation, Frames, Region, evaluate};
pub use measured::{
    Baselines, Confidence, Errors, LBS, Measured, MeasuredBaseline, MeasuredFrame, Millimetres,
    NEGLIGIBLE_PERCENT, OWN_WEIGHTS,
};
