//! One reference root for a skeleton that has several.

use crate::examples::Warning;

/// Hangs every joint without a parent, but the first, under the first.
pub(super) fn joined(
    names: &[String],
    mut parents: Vec<Option<usize>>,
    warnings: &mut Vec<Warning>,
) -> Vec<Option<usize>> {
    let roots: Vec<usize> = (0..parents.len()).filter(|&joint| parents[joint].is_none()).collect();
    if roots.len() > 1 {
        let joints = roots.iter().map(|&root| names[root].clone()).collect();
        warnings.push(Warning::SeveralRoots { joints });
    }
    for &root in roots.iter().skip(1) {
        parents[root] = Some(roots[0]);
    }
    parents
}
