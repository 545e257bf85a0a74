//! Calls the C functions in this process and compares results and errors with the runtime's.
#![allow(clippy::unwrap_used, reason = "a helper's failure is a failure of its test")]

#[path = "../../../runtime/tests/common/mod.rs"]
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

/// The first envelope and the first skin of a file, opened through C and by the runtime.
struct Both<'a> {
    model: Loaded,
    c: (handles::Envelope, handles::Skin),
    rust: (Envelope<'a>, Skin<'a>),
}

/// Runs a test on models of every predictor, with and without tangents. The models are made only once, because making
/// them takes seconds under Miri.
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
    test(Both {
        model,
        c,
        rust: (rust.first::<Envelope>().unwrap(), rust.first::<Skin>().unwrap()),
    });
}
