//! The functions, called in this process: they give what the runtime gives, and its errors.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

#[path = "../../../tests/common/mod.rs"]
mod common;
mod described;
mod errors;
mod evaluated;
mod handles;
mod kernels;
mod posed;
mod priors;
mod views;

use handles::Loaded;
use models::{Pieces, SMALL, Shape};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::{Envelope, Model, Skin};
use std::sync::LazyLock;

const BARE: Shape = Shape { tangents: false, ..SMALL };
const EMPTY: Shape = Shape { vertices: 0, ..SMALL };

/// The first envelope and the first skin of a file, through C and as the runtime has them.
struct Both<'a> {
    model: Loaded,
    c: (handles::Envelope, handles::Skin),
    rust: (Envelope<'a>, Skin<'a>),
}

/// Runs a test on a model of every predictor, with and without tangents. They are made once: under
/// Miri that takes seconds.
fn each(test: impl Fn(Both<'_>)) {
    static FILES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
        let each = Predictor::ALL.into_iter().flat_map(|each| [SMALL, BARE].map(|s| (each, s)));
        each.map(|(predictor, shape)| Pieces::sample(predictor, shape).bytes()).collect()
    });
    FILES.iter().for_each(|file| with(file, &test));
}

fn with(file: &[u8], test: impl Fn(Both<'_>)) {
    let model = Loaded::new(file);
    let c = (model.envelope(None, 0).unwrap(), model.skin(None, 0).unwrap());
    let rust = Model::from_bytes(file).unwrap();
    test(Both { model, c, rust: (rust.envelope().unwrap(), rust.skin().unwrap()) });
}
