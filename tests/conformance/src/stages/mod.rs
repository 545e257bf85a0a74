//! One body a stage, for any backend: all poses of a subject go through the stage as one batch, on
//! inputs that the CPU has made, and each is compared with the CPU's and with the oracle's.
//! The bounds stand in `tolerance/`, by the same names; `tests/stages/main.rs` runs the bodies.

pub mod bounds;
pub mod confidence;
pub mod correction;
pub mod features;
pub mod filter;
pub mod gradients;
pub mod joints;
pub mod kernel;
pub mod layout;
pub mod palette;
pub mod shapes;
pub mod skin;
pub mod whole;

pub use gradients::exact;

use crate::backend::{Backend, Failure, Loaded};
use crate::finding::Finding;
use crate::subject::Subject;
use sinew_gpu::layout::Stage;

/// What is compared of a stage, or of several.
pub type Body = fn(&dyn Backend, &Subject<'_>) -> Result<Vec<Finding>, Failure>;

/// Returns the body of a stage of an envelope or of its skin; kernels, shapes and filters have their own, as
/// [`kernel::body`].
///
/// # Panics
/// If the stage is one of those.
pub fn body(stage: Stage) -> Body {
    match stage {
        Stage::Gradients => gradients::body,
        Stage::Palette => palette::body,
        Stage::Joints => joints::body,
        Stage::Features => features::body,
        Stage::Correction => correction::body,
        Stage::Confidence => confidence::body,
        Stage::Skin => skin::body,
        Stage::Kernel | Stage::Shapes | Stage::Filter => panic!("it has no poses"),
    }
}

/// Whether a model has a stage to compare by itself. The confidence of models with a correction is
/// compared as an output of that.
pub fn applies(stage: Stage, backend: &dyn Backend, loaded: &Loaded<'_>) -> bool {
    let certain = stage == Stage::Confidence && loaded.envelope.predictor().corrects();
    !certain && backend.has(loaded, stage)
}
