//! Stage 1: each of its three outputs on the f32 inputs it was made from.

use crate::Subject;
use conformance::backend::{Backend, Gradients};
use conformance::compare::{Mismatch, within};
use conformance::tolerance::{self, Inexact, UNDERFLOW};
use nalgebra::{SMatrix, Vector3};
use sinew_runtime::{Envelope, Matrix3x4};

/// Largest ratios: relative maps, rotations, gradients.
pub(crate) fn body(backend: &impl Backend, subject: &Subject<'_>) -> Result<[f64; 3], Mismatch> {
    let Subject { envelope, oracle, poses, .. } = subject;
    let mut worst = [0.0_f64; 3];
    for pose in poses {
        let found = gradients_of(backend, envelope, &pose.maps);
        // Each part is compared before the next takes it as given.
        let relative = tolerance::relative(oracle, &Inexact::exact(pose.widened()));
        let relative = columns_within(&found.relative, &relative)?;
        let given = Inexact::exact(columns::<4>(&found.relative));
        let mut rotations = tolerance::rotations(oracle, &given);
        tolerance::same_branch(&mut rotations, &found.rotations);
        let rotations = rotations_within(&found.rotations, &rotations)?;
        let gradients = tolerance::gradients(oracle, &given, &exact_rotations(&found.rotations));
        let gradients = columns_within(&found.gradients, &gradients)?;
        let ratios = [relative, rotations, gradients];
        worst = std::array::from_fn(|i| worst[i].max(ratios[i]));
    }
    Ok(worst)
}

/// Evaluates the three of a pose.
pub(crate) fn gradients_of(
    backend: &impl Backend,
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
) -> Gradients {
    let mut out = Gradients::poisoned(envelope);
    let run = backend.gradients(envelope, pose, &mut out);
    run.expect("the pose is finite and the lengths are right");
    out
}

/// Cuts columns into blocks of C.
pub(crate) fn columns<const C: usize>(columns: &[[f32; 3]]) -> Vec<SMatrix<f64, 3, C>> {
    let blocks = columns.as_chunks::<C>().0.iter();
    blocks.map(|block| SMatrix::from_fn(|r, c| f64::from(block[c][r]))).collect()
}

/// Takes rotation vectors as given.
pub(crate) fn exact_rotations(list: &[[f32; 3]]) -> Inexact<Vector3<f64>, f64> {
    let value = list.iter().map(|v| Vector3::from(*v).map(f64::from)).collect();
    Inexact { value, error: vec![0.0; list.len()] }
}

fn columns_within<const C: usize>(
    found: &[[f32; 3]],
    expected: &Inexact<SMatrix<f64, 3, C>>,
) -> Result<f64, Mismatch> {
    let flat = |list: &[SMatrix<f64, 3, C>]| -> Vec<f64> {
        list.iter().flat_map(|m| m.iter().copied()).collect()
    };
    let tolerances: Vec<_> = flat(&expected.error).iter().map(|e| e + UNDERFLOW).collect();
    within(found.as_flattened(), &flat(&expected.value), &tolerances)
}

fn rotations_within(
    found: &[[f32; 3]],
    expected: &Inexact<Vector3<f64>, f64>,
) -> Result<f64, Mismatch> {
    let values: Vec<_> = expected.value.iter().flat_map(|v| v.iter().copied()).collect();
    let tolerances: Vec<_> = expected.error.iter().flat_map(|&e| [e + UNDERFLOW; 3]).collect();
    within(found.as_flattened(), &values, &tolerances)
}
