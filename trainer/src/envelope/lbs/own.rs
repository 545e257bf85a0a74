//! The weights that come with the mesh, as a baseline.

use super::blend::Weights;
use super::prior::painted;
use crate::examples::Examples;

/// Returns the joint weights that come with the mesh: all influences of a vertex, scaled to a sum of 1.
///
/// A vertex without weights takes its fitted ones. `None` where no vertex has any.
///
/// - `fitted`: LBS weights of the V vertices.
pub fn own_weights(examples: &Examples, fitted: &Weights) -> Option<Weights> {
    let own = painted(examples)?;
    let has_own: Vec<bool> = (0..own.len()).map(|vertex| own.strongest(vertex).is_some()).collect();
    if !has_own.contains(&true) {
        return None;
    }
    let of = |vertex: usize| if has_own[vertex] { &own } else { fitted };
    let lists = (0..own.len()).map(|vertex| of(vertex).of(vertex).collect());
    Some(Weights::from_lists(own.most().max(fitted.most()), lists))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::testing::triangle;

    #[test]
    fn all_influences_are_kept_and_vertices_without_weights_take_fitted_ones() {
        let mut examples = triangle(1);
        let fitted = Weights::from_lists(1, [0, 1, 1].map(|joint| vec![(joint, 1.0)]).into_iter());
        assert!(own_weights(&examples, &fitted).is_none());
        examples.joint_weights = Some(vec![0.0; 6]);
        assert!(own_weights(&examples, &fitted).is_none());
        examples.joint_weights = Some(vec![3.0, 1.0, 0.0, 0.0, 0.0, 0.5]);
        let found = own_weights(&examples, &fitted).unwrap();
        let lists: Vec<Vec<_>> = (0..3).map(|vertex| found.of(vertex).collect()).collect();
        assert_eq!(lists, [vec![(0, 0.75), (1, 0.25)], vec![(1, 1.0)], vec![(1, 1.0)]]);
    }
}
