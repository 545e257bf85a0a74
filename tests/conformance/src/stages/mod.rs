//! One body a stage, for any backend: all poses of a subject go through the stage as one batch, on
//! inputs that the CPU has made, and each is compared with the CPU's and with the oracle's.

pub mod bounds;
pub mod confidence;
pub mod correction;
pub mod features;
pub mod gradients;
pub mod joints;
pub mod layout;
pub mod palette;
pub mod skin;
pub mod whole;

use crate::backend::{Backend, Failure, Loaded, floats};
use crate::finding::Finding;
use crate::poses::widened;
use crate::subject::Subject;
use crate::tolerance::{Inexact, Transform, UNDERFLOW};
use sinew_gpu::layout::Stage;
use sinew_runtime::Matrix3x4;

/// What is compared of a stage, or of several.
pub type Body = fn(&dyn Backend, &Subject<'_>) -> Result<Vec<Finding>, Failure>;

/// Returns the body of a stage.
pub fn body(stage: Stage) -> Body {
    match stage {
        Stage::Gradients => gradients::body,
        Stage::Palette => palette::body,
        Stage::Joints => joints::body,
        Stage::Features => features::body,
        Stage::Correction => correction::body,
        Stage::Confidence => confidence::body,
        Stage::Skin => skin::body,
    }
}

/// Whether a model has a stage to compare by itself. The confidence of models with a correction is
/// compared as an output of that.
pub fn applies(stage: Stage, backend: &dyn Backend, loaded: &Loaded<'_>) -> bool {
    let certain = stage == Stage::Confidence && loaded.envelope.predictor().corrects();
    !certain && backend.has(loaded, stage)
}

/// Takes transforms as given.
pub fn exact(transforms: &[Matrix3x4]) -> Inexact<Transform> {
    Inexact::exact(transforms.iter().map(widened).collect())
}

/// Compares transforms with the CPU's and with those expected.
fn compare_transforms(
    finding: &mut Finding,
    found: &[Matrix3x4],
    cpu: &[Matrix3x4],
    expected: &Inexact<Transform>,
) -> bool {
    let flat = |list: &[Transform]| -> Vec<f64> {
        list.iter().flat_map(|m| m.transpose().iter().copied().collect::<Vec<_>>()).collect()
    };
    let tolerances: Vec<_> = flat(&expected.error).iter().map(|e| e + UNDERFLOW).collect();
    finding.compare(floats(found), floats(cpu), &flat(&expected.value), &tolerances)
}
