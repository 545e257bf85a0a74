//! The demo's arm: examples, model file and poses.

use sinew_runtime::Matrix3x4;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::Space;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::examples::Examples;
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::progress::Silent;
use std::sync::LazyLock;

/// Examples of an arm of about 500 vertices, in glTF's axes and metres.
pub static EXAMPLES: LazyLock<Examples> = LazyLock::new(|| {
    let options = DemoOptions { vertices: 500, poses: 30, held_out: 10, seed: 4 };
    Examples { space: Space::GLTF, ..demo(&options) }
});

/// Model trained on the examples.
pub static FILE: LazyLock<Vec<u8>> = LazyLock::new(|| file(&EXAMPLES, Predictor::Kernel));

/// Trains a model on examples of the demo's size, in a second or two.
///
/// # Panics
/// If the training fails.
pub fn file(examples: &Examples, predictor: Predictor) -> Vec<u8> {
    let options = Options {
        predictor: Predict::Only(predictor),
        proxies: Some(ProxyCount::Fixed(12)),
        ..Options::default()
    };
    train(examples, &options, &Silent).expect("the arm trains").model
}

/// Returns the skinning matrices of a frame.
pub fn pose(examples: &Examples, frame: usize) -> Vec<Matrix3x4> {
    examples.pose(frame).iter().map(|m| m.map(|row| row.map(|x| x as f32))).collect()
}
