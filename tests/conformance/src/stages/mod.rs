//! One function for each stage compares any backend: all poses of a subject go through the stage as
//! one batch, on inputs that the CPU has computed. The outputs are compared with the CPU's bits and
//! with the oracle. The tolerances are in `tolerance/`, by the same names; `tests/stages/main.rs`
//! runs the comparisons.

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
pub mod polar;
pub mod shapes;
pub mod skin;
pub mod whole;

pub use gradients::exact;

use crate::backend::{Backend, Failure, Loaded};
use crate::finding::Finding;
use crate::subject::Subject;
use sinew_gpu::layout::Stage;

/// Compares the outputs of a stage, or of several.
pub type Body = fn(&dyn Backend, &Subject<'_>) -> Result<Vec<Finding>, Failure>;

/// Returns the comparison of a stage of an envelope or of its skin. Kernels, shapes and filters
/// have their own, for example [`kernel::body`].
///
/// # Panics
/// If the stage belongs to a kernel, to shapes or to a filter.
pub fn body(stage: Stage) -> Body {
    match stage {
        Stage::Polar => polar::body,
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

/// Whether a stage is compared alone for a model. For models with a correction, the confidence is
/// compared as an output of the correction.
pub fn applies(stage: Stage, backend: &dyn Backend, loaded: &Loaded<'_>) -> bool {
    let certain = stage == Stage::Confidence && loaded.envelope.predictor().corrects();
    !certain && backend.has(loaded, stage)
}
