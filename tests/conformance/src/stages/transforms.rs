//! Transforms as stages take and give them.

use crate::backend::floats;
use crate::finding::Finding;
use crate::poses::widened;
use crate::tolerance::{Inexact, Transform, UNDERFLOW};
use sinew_runtime::Matrix3x4;

/// Takes transforms as given.
pub fn exact(transforms: &[Matrix3x4]) -> Inexact<Transform> {
    Inexact::exact(transforms.iter().map(widened).collect())
}

/// Compares transforms with the CPU's and with those expected.
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
