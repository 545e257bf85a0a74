//! One reference root for a skeleton that has several.

use crate::examples::Warning;

/// Hangs every joint without a parent, but the first, under the first; gives all parents, and those joints.
pub(super) fn joined(
    names: &[String],
    mut parents: Vec<Option<usize>>,
    warnings: &mut Vec<Warning>,
) -> (Vec<Option<usize>>, Vec<usize>) {
    let roots: Vec<usize> = (0..parents.len()).filter(|&joint| parents[joint].is_none()).collect();
    let Some((&reference, others)) = roots.split_first() else { return (parents, roots) };
    if !others.is_empty() {
        let joints = roots.iter().map(|&root| names[root].clone()).collect();
        warnings.push(Warning::SeveralRoots { joints });
    }
    others.iter().for_each(|&root| parents[root] = Some(reference));
    (parents, others.to_vec())
}
