//! How far the skin is from the joints' bones (METHOD §1.2): what poses do not tell of which it follows.

use super::poses::Poses;
use crate::constants::NEAR;
use crate::examples::Examples;
use faer::Mat;
use nalgebra::Vector3;

/// How many times farther each joint's bone is from each vertex than the nearest is, J x V numbers of at least 1.
///
/// - `poses`: of the training frames, in any unit. They place a joint of which the source does not say where it is, if it
///   turns against its parent; else nothing does, and it is far from all.
pub fn distances(examples: &Examples, poses: &Poses) -> Mat<f64> {
    let (skeleton, unit) = (&examples.skeleton, examples.diagonal());
    let parents = skeleton.own_parents();
    let turns = |joint: usize| parents[joint].is_some_and(|up| !poses.turn_as_one(joint, up));
    let is_placed = |joint: usize| !skeleton.unplaced.contains(&joint) || turns(joint);
    let origins: Vec<Vector3<f64>> =
        skeleton.rest.iter().map(|frame| frame.map(|row| row[3]).into()).collect();
    let bones =
        |joint| if is_placed(joint) { bones(joint, &parents, &origins) } else { Vec::new() };
    let bones: Vec<Vec<Bone>> = (0..origins.len()).map(bones).collect();
    let distances = Mat::from_fn(origins.len(), examples.vertex_len(), |joint, vertex| {
        let x = Vector3::from(examples.rest[vertex]);
        let own = bones[joint].iter().map(|bone| bone.distance(&x));
        own.fold(unit, f64::min) + NEAR.get() * unit
    });
    let nearest =
        |vertex: usize| distances.col(vertex).iter().copied().fold(f64::INFINITY, f64::min);
    let nearest: Vec<f64> = (0..distances.ncols()).map(nearest).collect();
    Mat::from_fn(distances.nrows(), nearest.len(), |j, v| distances[(j, v)] / nearest[v])
}

/// A bone, from a joint's origin to a child's.
struct Bone {
    from: Vector3<f64>,
    along: Vector3<f64>,
}

/// Gives the bones of a joint: one to each child; without children one as long as its parent's, on from there.
fn bones(joint: usize, parents: &[Option<usize>], origins: &[Vector3<f64>]) -> Vec<Bone> {
    let from = origins[joint];
    let children = (0..origins.len()).filter(|&child| parents[child] == Some(joint));
    let mut bones: Vec<Bone> =
        children.map(|child| Bone { from, along: origins[child] - from }).collect();
    if bones.is_empty() {
        let along = parents[joint].map_or_else(Vector3::zeros, |up| from - origins[up]);
        bones.push(Bone { from, along });
    }
    bones
}

impl Bone {
    fn distance(&self, x: &Vector3<f64>) -> f64 {
        let (apart, square) = (x - self.from, self.along.norm_squared());
        let at = if square > 0.0 { apart.dot(&self.along) / square } else { 0.0 };
        (apart - self.along * at.clamp(0.0, 1.0)).norm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::testing::triangle;

    /// Joints at 0 and 1 on the x axis, of which the second may turn, and three vertices.
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
        distances(examples, &Poses::new(examples, &[0, 1]))
    }

    #[test]
    fn distances_are_those_from_segments_over_the_nearest() {
        let examples = pair(false);
        let found = found(&examples);
        let near = NEAR.get() * examples.diagonal();
        // The second bone goes on from 1 to 2.
        let far = |x: f64, y: f64| x.hypot(y) + near;
        let expected = [
            [1.0, far(0.5, 0.2) / far(0.0, 0.2)],
            [far(0.5, 0.2) / far(0.0, 0.2), 1.0],
            [1.0, far(1.0, 1.0) / far(0.0, 1.0)],
        ];
        for (vertex, expected) in expected.iter().enumerate() {
            for (joint, expected) in expected.iter().enumerate() {
                assert!((found[(joint, vertex)] - expected).abs() < 1e-12, "{joint} {vertex}");
            }
        }
    }

    #[test]
    fn joints_that_nothing_places_are_far() {
        for turns in [false, true] {
            let mut examples = pair(turns);
            examples.skeleton.unplaced = vec![1];
            let found = found(&examples);
            assert_eq!(found[(1, 1)] == 1.0, turns);
            assert_eq!(found[(0, 1)] == 1.0, !turns);
        }
    }

    #[test]
    fn limbs_that_swing_alike_carry_their_own_skin() {
        let frames = [0.0, 0.2, -0.3, 0.5, -0.1, 0.4, -0.5];
        let mut examples = triangle(frames.len());
        // Two limbs down from hips on the z axis, about which both turn.
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
        // What no joint explains: the skin swells with the angle, to its own side.
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
        let weights = super::super::weights::baseline(&examples);
        for vertex in 0..20 {
            let own = usize::from(vertex >= 10);
            let stray: f64 =
                weights.of(vertex).filter(|(j, _)| *j > 0 && (j - 1) % 2 != own).map(|w| w.1).sum();
            assert!(stray < 1e-9, "{vertex} {:?}", weights.of(vertex).collect::<Vec<_>>());
        }
    }
}
