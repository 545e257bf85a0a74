//! Poses of an engine.

mod binding;
mod faults;
mod results;

use models::{GOLDEN, Pieces, SMALL, STRETCHING, Shape};
use sinew_runtime::envelope::{LocalTransform, Predictor};
use sinew_runtime::{Envelope, Matrix3x4, Model, matrix, model_space_pose};

/// Runs a test on the envelopes of the golden files and of samples. One sample stretches joints 1
/// and 2 and has curves.
fn each(test: impl Fn(&Envelope<'_>)) {
    let samples = [SMALL, STRETCHING].map(|shape| Pieces::sample(Predictor::Kernel, shape).bytes());
    for file in GOLDEN.into_iter().chain(samples.each_ref().map(Vec::as_slice)) {
        test(&Model::from_bytes(file).unwrap().first::<Envelope>().unwrap());
    }
}

/// Runs a test on the envelope of a kernel sample.
fn sample(shape: Shape, test: impl FnOnce(&Envelope<'_>)) {
    let model = Model::from_bytes(Pieces::sample(Predictor::Kernel, shape).bytes()).unwrap();
    test(&model.first::<Envelope>().unwrap());
}

/// A pose with each joint rotated against its rest frame, about its own axis.
fn turned(envelope: &Envelope<'_>, angle: f32) -> Vec<LocalTransform> {
    let turn = |(joint, local): (usize, LocalTransform)| {
        let (sine, cosine) = (0.5 * angle * (1.0 + joint as f32)).sin_cos();
        let axis = [[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [0.8, -0.6, 0.0]][joint % 3];
        let [x, y, z] = axis.map(|a| sine * a);
        let ([a, b, c, d], w) = (local.rotation, cosine);
        let rotation = [
            d * x + a * w + b * z - c * y,
            d * y - a * z + b * w + c * x,
            d * z + a * y - b * x + c * w,
            d * w - a * x - b * y - c * z,
        ];
        LocalTransform { rotation, ..local }
    };
    envelope.rest_locals().enumerate().map(turn).collect()
}

/// The curves at rest.
fn still(envelope: &Envelope<'_>) -> Vec<f32> {
    vec![0.0; envelope.curve_len()]
}

fn posed(envelope: &Envelope<'_>, local: &[LocalTransform]) -> Vec<Matrix3x4> {
    let mut pose = vec![matrix::IDENTITY; local.len()];
    model_space_pose(envelope, local, &mut pose).unwrap();
    pose
}

fn apart(a: &[Matrix3x4], b: &[Matrix3x4]) -> f32 {
    let pairs = a.as_flattened().as_flattened().iter().zip(b.as_flattened().as_flattened());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

fn after(a: &Matrix3x4, b: &Matrix3x4) -> Matrix3x4 {
    let entry = |row: &[f32; 4], c: usize| {
        (0..3).map(|k| row[k] * b[k][c]).sum::<f32>() + if c == 3 { row[3] } else { 0.0 }
    };
    a.map(|row| std::array::from_fn(|c| entry(&row, c)))
}

const ACTOR: Matrix3x4 = [[0.0, -1.0, 0.0, 2.0], [1.0, 0.0, 0.0, -0.25], [0.0, 0.0, 1.0, 3.5]];
