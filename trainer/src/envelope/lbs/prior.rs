//! Prior joint weights, which decide where the poses do not (METHOD §1.2), and the mesh's own weights.

use super::blend::Weights;
use super::poses::Poses;
use crate::examples::{Examples, Matrix3x4};
use faer::Mat;
use nalgebra::Vector3;

/// Distance in diagonals that is added to the distance from a bone: inside a limb all its bones are near.
const NEAR: f64 = 0.03;
/// Exponent of the fall of a weight with the distance from the joint's bone.
const POWER: i32 = 8;

/// Returns the prior weights of the joints, J x V. The weights of a vertex sum to 1.
///
/// A painted vertex has its painted weights. The weights of other vertices fall with the distance from the bones.
///
/// - `poses`: the training poses, in any unit.
pub fn prior(examples: &Examples, poses: &Poses) -> Mat<f64> {
    let mut prior = by_bones(examples, poses);
    for (vertex, row) in painted_rows(examples).enumerate() {
        let sum: f64 = row.iter().sum();
        if sum > 0.0 {
            let column = prior.col_as_slice_mut(vertex);
            column.iter_mut().zip(row).for_each(|(weight, painted)| *weight = painted / sum);
        }
    }
    prior
}

/// Returns the painted weights, normalised; `None` if the examples have none. A vertex without paint has no weights.
pub fn painted(examples: &Examples) -> Option<Weights> {
    examples.joint_weights.as_ref()?;
    let list = |row: &[f64]| {
        let sum: f64 = row.iter().sum();
        let some = row.iter().enumerate().filter(|(_, weight)| **weight > 0.0);
        let mut list: Vec<_> = some.map(|(joint, weight)| (joint, weight / sum)).collect();
        list.sort_by(|a, b| b.1.total_cmp(&a.1));
        list
    };
    let lists: Vec<_> = painted_rows(examples).map(list).collect();
    let most = lists.iter().map(Vec::len).max().unwrap_or(0).max(1);
    Some(Weights::from_lists(most, lists.into_iter()))
}

/// Lists the painted weights of each vertex on J joints.
fn painted_rows(examples: &Examples) -> impl Iterator<Item = &[f64]> {
    examples.joint_weights.iter().flat_map(|all| all.chunks_exact(examples.joint_len()))
}

/// Returns weights that fall with the distance from each joint's bones, J x V.
///
/// Some sources give no origin for a joint. If such a joint turns against its parent, its motion gives the origin.
/// Otherwise only the origins of its children give its bones.
fn by_bones(examples: &Examples, poses: &Poses) -> Mat<f64> {
    let (skeleton, unit) = (&examples.skeleton, examples.diagonal());
    let parents = skeleton.own_parents();
    let turns = |joint: usize| parents[joint].is_some_and(|up| !poses.turn_together(joint, up));
    let place = |(joint, frame): (usize, &Matrix3x4)| {
        let is_placed = !skeleton.unplaced.contains(&joint) || turns(joint);
        is_placed.then(|| frame.map(|row| row[3]).into())
    };
    let places: Vec<_> = skeleton.rest.iter().enumerate().map(place).collect();
    let bones: Vec<_> = (0..places.len()).map(|joint| bones_of(joint, &parents, &places)).collect();
    let mut weights = Mat::from_fn(bones.len(), examples.vertex_len(), |joint, vertex| {
        let x = Vector3::from(examples.rest[vertex]);
        let distances = bones[joint].iter().map(|bone| bone.distance(&x));
        (distances.fold(unit, f64::min) / unit + NEAR).powi(-POWER)
    });
    for vertex in 0..weights.ncols() {
        let of_joints = weights.col_as_slice_mut(vertex);
        let sum: f64 = of_joints.iter().sum();
        of_joints.iter_mut().for_each(|weight| *weight /= sum);
    }
    weights
}

/// A bone, from a joint's origin to a child's.
struct Bone {
    from: Vector3<f64>,
    along: Vector3<f64>,
}

/// Lists the bones of a joint, one to each child. A joint without children continues its parent's bone at full length.
/// A joint without an origin has a bone of length 0 at each child's origin.
fn bones_of(joint: usize, parents: &[Option<usize>], places: &[Option<Vector3<f64>>]) -> Vec<Bone> {
    let children = (0..places.len()).filter(|&child| parents[child] == Some(joint));
    let children = children.filter_map(|child| places[child]);
    let Some(from) = places[joint] else {
        return children.map(|from| Bone { from, along: Vector3::zeros() }).collect();
    };
    let mut bones: Vec<Bone> = children.map(|child| Bone { from, along: child - from }).collect();
    if bones.is_empty() {
        let parent = parents[joint].and_then(|parent| places[parent]);
        bones.push(Bone { from, along: parent.map_or_else(Vector3::zeros, |up| from - up) });
    }
    bones
}

impl Bone {
    fn distance(&self, x: &Vector3<f64>) -> f64 {
        let (offset, square) = (x - self.from, self.along.norm_squared());
        let at = if square > 0.0 { offset.dot(&self.along) / square } else { 0.0 };
        (offset - self.along * at.clamp(0.0, 1.0)).norm()
    }
}

/// Returns the mesh's own joint weights: all influences of a vertex, scaled to a sum of 1. A vertex without weights
/// gets its fitted weights. `None` if no vertex has weights.
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
    use crate::examples::demo::{DemoOptions, demo};
    use crate::examples::testing::triangle;

    /// Two joints at 0 and 1 on the x axis, and three vertices. The second joint may turn.
    fn pair(turns: bool) -> Examples {
        let mut examples = triangle(2);
        examples.rest = vec![[0.5, 0.2, 0.0], [1.5, 0.2, 0.0], [0.0, 1.0, 0.0]];
        examples.skeleton.rest[1][0][3] = 1.0;
        if turns {
            examples.transforms[3] =
                [[0.0, -1.0, 0.0, 1.0], [1.0, 0.0, 0.0, -1.0], [0.0, 0.0, 1.0, 0.0]];
        }
        examples
    }

    fn found(examples: &Examples) -> Mat<f64> {
        prior(examples, &Poses::new(examples, &[0, 1]))
    }

    #[test]
    fn weights_fall_with_the_distance_from_segments() {
        let examples = pair(false);
        let found = found(&examples);
        // The bone of the second joint continues from 1 to 2.
        let weight = |x: f64, y: f64| (x.hypot(y) / examples.diagonal() + NEAR).powi(-8);
        let expected = [
            [weight(0.0, 0.2), weight(0.5, 0.2)],
            [weight(0.5, 0.2), weight(0.0, 0.2)],
            [weight(0.0, 1.0), weight(1.0, 1.0)],
        ];
        for (vertex, expected) in expected.iter().enumerate() {
            let sum: f64 = expected.iter().sum();
            for (joint, expected) in expected.iter().enumerate() {
                assert!(
                    (found[(joint, vertex)] - expected / sum).abs() < 1e-12,
                    "{joint} {vertex}"
                );
            }
        }
    }

    #[test]
    fn painted_weights_stay_and_other_vertices_get_weights_by_distance() {
        let mut examples = pair(false);
        let by_bones = found(&examples);
        examples.joint_weights = Some(vec![3.0, 1.0, 0.0, 0.0, 0.0, 0.5]);
        let found = found(&examples);
        for (vertex, expected) in [(0, [0.75, 0.25]), (2, [0.0, 1.0])] {
            assert_eq!([found[(0, vertex)], found[(1, vertex)]], expected);
        }
        assert_eq!(found.col(1), by_bones.col(1));
        let painted = painted(&examples).unwrap();
        let lists: Vec<Vec<_>> = (0..3).map(|vertex| painted.of(vertex).collect()).collect();
        assert_eq!(lists, [vec![(0, 0.75), (1, 0.25)], vec![], vec![(1, 1.0)]]);
    }

    #[test]
    fn joints_without_an_origin_get_small_weights() {
        for turns in [false, true] {
            let mut examples = pair(turns);
            examples.skeleton.unplaced = vec![1];
            let found = found(&examples);
            assert_eq!(found[(1, 1)] > 0.5, turns);
            assert_eq!(found[(0, 1)] > 0.5, !turns);
        }
    }

    #[test]
    fn joints_without_an_origin_end_no_bone() {
        let mut examples = pair(false);
        examples.skeleton.unplaced = vec![1];
        examples.place_joints();
        let ratio = found(&examples)[(1, 1)] / found(&examples)[(0, 1)];
        let from_root = f64::hypot(1.5, 0.2) / examples.diagonal() + NEAR;
        assert!((ratio / (from_root / (1.0 + NEAR)).powi(8) - 1.0).abs() < 1e-9, "no bone to it");
        let mut examples = pair(false);
        examples.skeleton.unplaced = vec![0];
        examples.place_joints();
        let found = found(&examples);
        // The root gets its child's origin, where the child's bone starts.
        assert!((found[(0, 0)] - 0.5).abs() < 1e-12 && (found[(1, 0)] - 0.5).abs() < 1e-12);
    }

    #[test]
    fn weights_do_not_depend_on_the_origin() {
        let examples = demo(&DemoOptions { vertices: 200, poses: 12, held_out: 0, seed: 1 });
        let mut moved = examples.clone();
        let far = |x: &mut [f64; 3]| x[0] += 1000.0;
        moved.rest.iter_mut().for_each(far);
        moved.vertices.iter_mut().for_each(far);
        moved.skeleton.rest.iter_mut().for_each(|frame| frame[0][3] += 1000.0);
        for map in &mut moved.transforms {
            let turned = [map[0][0], map[1][0], map[2][0]].map(|x| 1000.0 * x);
            (0..3).for_each(|row| map[row][3] -= turned[row]);
            map[0][3] += 1000.0;
        }
        let [here, there] = [&examples, &moved].map(super::super::weights::baseline);
        for vertex in 0..here.len() {
            for (here, there) in here.of(vertex).zip(there.of(vertex)) {
                assert_eq!(here.0, there.0, "{vertex}");
                assert!((here.1 - there.1).abs() < 1e-6, "{vertex}: {here:?} {there:?}");
            }
        }
    }

    /// Two limbs with equal motion, ten vertices on each.
    fn limbs() -> Examples {
        let frames = [0.0, 0.2, -0.3, 0.5, -0.1, 0.4, -0.5];
        let mut examples = triangle(frames.len());
        // Two limbs hang down from hips on the z axis and turn about the z axis.
        let places = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.5], [0.0, 0.0, -0.5]];
        let skeleton = &mut examples.skeleton;
        skeleton.names =
            ["hips", "left", "right", "left tip", "right tip"].map(str::to_owned).into();
        skeleton.parents = vec![None, Some(0), Some(0), Some(1), Some(2)];
        let tips = [[0.0, -1.0, 0.5], [0.0, -1.0, -0.5]];
        let frame =
            |[x, y, z]: [f64; 3]| [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]];
        skeleton.rest = places.into_iter().chain(tips).map(frame).collect();
        let side = |k: usize| if k < 10 { 0.5 } else { -0.5 };
        let rest = |k: usize| [0.1, -0.1 * (k % 10) as f64 - 0.05, side(k)];
        examples.rest = (0..20).map(rest).collect();
        let turned = |angle: f64, [x, y, z]: [f64; 3]| {
            let (s, c) = f64::sin_cos(angle);
            [c * x - s * y, s * x + c * y, z]
        };
        // A motion beyond LBS: the skin of each limb swells outward with the angle.
        let swollen = |angle: f64, x: [f64; 3]| [x[0], x[1], x[2] * (1.0 + 0.05 * angle.abs())];
        examples.vertices.clear();
        examples.transforms.clear();
        for angle in frames {
            let turn = |x| turned(angle, swollen(angle, x));
            examples.vertices.extend(examples.rest.iter().map(|&x| turn(x)));
            let (s, c) = f64::sin_cos(angle);
            let limb = [[c, -s, 0.0, 0.0], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
            examples.transforms.extend([frame([0.0; 3]), limb, limb, limb, limb]);
        }
        examples
    }

    #[test]
    fn limbs_with_equal_motion_carry_their_own_skin() {
        let weights = super::super::weights::baseline(&limbs());
        for vertex in 0..20 {
            let own = usize::from(vertex >= 10);
            let stray: f64 =
                weights.of(vertex).filter(|(j, _)| *j > 0 && (j - 1) % 2 != own).map(|w| w.1).sum();
            assert!(stray < 1e-9, "{vertex} {:?}", weights.of(vertex).collect::<Vec<_>>());
        }
    }

    #[test]
    fn limbs_with_equal_motion_keep_painted_weights() {
        let mut examples = limbs();
        let painted = |vertex: usize| if vertex < 10 { 2 } else { 1 };
        let row = |vertex: usize| (0..5).map(move |j| f64::from(u8::from(j == painted(vertex))));
        examples.joint_weights = Some((0..20).flat_map(row).collect());
        let weights = super::super::weights::baseline(&examples);
        for vertex in 0..20 {
            let found: f64 =
                weights.of(vertex).filter(|w| w.0 == painted(vertex)).map(|w| w.1).sum();
            assert!(found > 0.999, "{vertex} {:?}", weights.of(vertex).collect::<Vec<_>>());
        }
    }

    #[test]
    fn all_influences_are_kept_and_vertices_without_weights_get_fitted_weights() {
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
