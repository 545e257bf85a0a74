//! Stage gradients: each of its three outputs, given the f32 inputs of that output. Also the
//! conversions that several stages use.

use super::polar::{compare_columns, split_of};
use crate::backend::{Backend, Failure, Gradients, Split, floats, part};
use crate::cpu::Cpu;
use crate::finding::Finding;
use crate::poses::widened;
use crate::subject::Subject;
use crate::tolerance::{self, Inexact, Transform, UNDERFLOW};
use nalgebra::{SMatrix, Vector3};
use sinew_runtime::Matrix3x4;

/// Compares relative transforms, rotations and gradients.
///
/// # Errors
/// The backend's error.
pub fn body(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Finding>, Failure> {
    let (oracle, n, arithmetic) = (&subject.oracle, subject.poses.len(), backend.arithmetic());
    let split = split_of(&Cpu, subject)?;
    let (found, cpu) =
        (gradients_on(backend, subject, &split)?, gradients_on(&Cpu, subject, &split)?);
    let [mut relative, mut rotations, mut gradients] =
        ["relative", "rotations", "gradients"].map(Finding::new);
    for (i, pose) in subject.poses.iter().enumerate() {
        let at = |pick: fn(&Gradients) -> &Vec<[f32; 3]>| {
            (part(pick(&found), n, i), part(pick(&cpu), n, i))
        };
        // Each output is compared before it becomes the input of the next.
        let pose = Inexact::exact(pose.widened());
        let expected = tolerance::relative(oracle, &pose, arithmetic);
        let (found_relative, cpu_relative) = at(|all| &all.relative);
        if !compare_columns(&mut relative, found_relative, cpu_relative, &expected) {
            continue;
        }
        let found_relative = Inexact::exact(columns::<4>(found_relative));
        let given = tolerance::turning(oracle, &pose, &found_relative);
        let (found_rotations, cpu_rotations) = at(|all| &all.rotations);
        let mut expected = tolerance::rotations(oracle, given, arithmetic);
        tolerance::same_branch(&mut expected, found_rotations);
        if !compare_rotations(&mut rotations, found_rotations, cpu_rotations, &expected) {
            continue;
        }
        let turned = exact_rotations(found_rotations);
        let expected = tolerance::gradients(oracle, given, &turned, arithmetic);
        let (found_gradients, cpu_gradients) = at(|all| &all.gradients);
        compare_columns(&mut gradients, found_gradients, cpu_gradients, &expected);
    }
    Ok(vec![relative, rotations, gradients])
}

/// Evaluates the three outputs for every pose, after stage polar.
///
/// # Errors
/// The backend's error.
pub fn gradients_of(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Gradients, Failure> {
    gradients_on(backend, subject, &split_of(backend, subject)?)
}

/// Evaluates the three outputs for every pose from outputs of stage polar.
fn gradients_on(
    backend: &dyn Backend,
    subject: &Subject<'_>,
    split: &Split,
) -> Result<Gradients, Failure> {
    let mut out = Gradients::poisoned(&subject.loaded.envelope, subject.poses.len());
    backend.gradients(&subject.loaded, subject.inputs(), split, &mut out)?;
    Ok(out)
}

/// Groups columns into matrices of C columns.
pub fn columns<const C: usize>(columns: &[[f32; 3]]) -> Vec<SMatrix<f64, 3, C>> {
    let blocks = columns.as_chunks::<C>().0.iter();
    blocks.map(|block| SMatrix::from_fn(|r, c| f64::from(block[c][r]))).collect()
}

/// Converts rotation vectors to exact values.
pub fn exact_rotations(list: &[[f32; 3]]) -> Inexact<Vector3<f64>, f64> {
    let value = list.iter().map(|v| Vector3::from(*v).map(f64::from)).collect();
    Inexact { value, error: vec![0.0; list.len()] }
}

fn compare_rotations(
    finding: &mut Finding,
    found: &[[f32; 3]],
    cpu: &[[f32; 3]],
    expected: &Inexact<Vector3<f64>, f64>,
) -> bool {
    let values: Vec<_> = expected.value.iter().flat_map(|v| v.iter().copied()).collect();
    let tolerances: Vec<_> = expected.error.iter().flat_map(|&e| [e + UNDERFLOW; 3]).collect();
    finding.compare(found.as_flattened(), cpu.as_flattened(), &values, &tolerances)
}

/// Converts transforms to exact values.
pub fn exact(transforms: &[Matrix3x4]) -> Inexact<Transform> {
    Inexact::exact(transforms.iter().map(widened).collect())
}

/// Compares transforms with the CPU's bits and with the expected values.
pub(super) fn compare_transforms(
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
