//! A batch of shapes, beside those of envelopes and kernels.

use super::load;
use models::Pieces;
use sinew_gpu::layout::{DeviceLimits, Plan, ShapesBatch};

/// Plans three instances of the shapes of a skin; returns the blob beside.
pub(crate) fn shapes_plan(limits: &DeviceLimits) -> (Plan, Vec<u8>) {
    let [.., face] = Pieces::shaped();
    let bytes = face.bytes();
    let model = load(&bytes);
    let skin = model.skin().unwrap();
    let plan = Plan::of_shapes(&model, &skin, &ShapesBatch::new(&skin, 3), limits).unwrap();
    (plan, model.blob().to_vec())
}
