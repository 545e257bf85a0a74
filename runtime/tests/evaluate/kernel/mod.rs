//! Results of a kernel, and refused calls.

mod bound;
mod derivatives;
mod exact;
mod outputs;
mod refusals;
mod values;

use models::{KernelContent, Pieces};
use sinew_runtime::{CallError, KernelMap, Model};

/// Runs a test on a kernel in its own file.
fn with<T>(content: &KernelContent, test: impl FnOnce(KernelMap<'_>) -> T) -> T {
    let model = Model::from_bytes(Pieces::kernels(std::slice::from_ref(content)).bytes()).unwrap();
    test(model.first::<KernelMap>().unwrap())
}

/// Evaluates a query in scratch of exactly the stated length; returns outputs and confidence.
fn evaluate(map: &KernelMap<'_>, query: &[f32]) -> Result<(Vec<f32>, f32), CallError> {
    let mut scratch = vec![f32::NAN; map.counts().scratch_len()];
    let mut out = vec![f32::NAN; map.result_len()];
    let confidence = map.evaluate(query, &mut scratch, &mut out);
    // An error has written nothing.
    assert!(confidence.is_ok() || out.iter().all(|x| x.is_nan()));
    confidence.map(|confidence| (out, confidence))
}

/// Computes the Jacobian in scratch of exactly the stated length, row by row.
fn jacobian(map: &KernelMap<'_>, query: &[f32]) -> Result<Vec<f32>, CallError> {
    let counts = map.counts();
    let mut scratch = vec![f32::NAN; counts.jacobian_scratch_len()];
    let mut out = vec![f32::NAN; counts.value_len as usize * map.query_len()];
    let done = map.jacobian(query, &mut scratch, &mut out);
    assert!(done.is_ok() || out.iter().all(|x| x.is_nan()));
    done.map(|()| out)
}

/// Computes the variance in scratch of exactly the stated length.
fn variance(map: &KernelMap<'_>, query: &[f32]) -> Result<Vec<f32>, CallError> {
    let counts = map.counts();
    let mut scratch = vec![f32::NAN; counts.variance_scratch_len()];
    let mut out = vec![f32::NAN; counts.value_len as usize];
    let done = map.variance(query, &mut scratch, &mut out);
    assert!(done.is_ok() || out.iter().all(|x| x.is_nan()));
    done.map(|()| out)
}
