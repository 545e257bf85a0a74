//! The demo's arm, as a file and as poses.

use sinew_runtime::Matrix3x4;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::Space;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::examples::Examples;
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::progress::Silent;
use std::sync::LazyLock;

/// An arm of some 500 vertices, in glTF's axes and metres.
pub static EXAMPLES: LazyLock<Examples> = LazyLock::new(|| {
    let options = DemoOptions { vertices: 500, poses: 30, held_out: 10, seed: 4 };
    Examples { space: Space::GLTF, ..demo(&options) }
});

/// What a training makes of it.
pub static FILE: LazyLock<Vec<u8>> = LazyLock::new(|| file(&EXAMPLES, Predictor::Kernel));

/// Trains a model of examples, as the demo's are, in a second or two.
///
/// # Panics
/// If they do not train.
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
