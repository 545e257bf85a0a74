//! Joints that move nothing.

use super::rigidity::deviation;
use super::validate::RIGID;
use super::{Examples, Matrix3x4, Skeleton, Warning};
use crate::numeric::affine::{joined, parts, to_rows};
use crate::numeric::so3::polar;
use nalgebra::{Matrix3, Vector3};

/// Marks the joints that move no vertex and carry no joint that does.
///
/// - `joint_weights`: painted weights of a mesh, V x J; without them no joint is marked.
/// - `parents`: of the J joints.
pub(super) fn idle(joint_weights: Option<&[f64]>, parents: &[Option<usize>]) -> Vec<bool> {
    let Some(weights) = joint_weights else { return vec![false; parents.len()] };
    let mut idle = vec![true; parents.len()];
    for row in weights.chunks_exact(parents.len().max(1)) {
        for (joint, _) in row.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let mut next = Some(joint);
            while let Some((joint, place)) = next.and_then(|at| Some((at, idle.get_mut(at)?))) {
                next = parents[joint].filter(|_| *place);
                *place = false;
            }
        }
    }
    idle
}

impl Examples {
    /// Removes the scale of idle joints, such as sockets. They move and turn as before. Returns a warning that names the
    /// joints that were scaled.
    pub(crate) fn unscale_idle_joints(&mut self) -> Option<Warning> {
        let joint_len = self.joint_len();
        let Skeleton { parents, rest, .. } = &self.skeleton;
        if parents.len() != joint_len || rest.len() != joint_len {
            return None;
        }
        let idle = idle(self.joint_weights.as_deref(), parents);
        let is_off = |map: &Matrix3x4| {
            map.as_flattened().iter().all(|x| x.is_finite()) && deviation(map) > RIGID
        };
        let mut joints = Vec::new();
        for joint in (0..joint_len).filter(|&joint| idle[joint]) {
            let rest = &mut self.skeleton.rest[joint];
            let origin = Vector3::from(rest.map(|row| row[3]));
            let posed = self.transforms.iter_mut().skip(joint).step_by(joint_len);
            let maps = posed.map(|map| (map, origin)).chain([(rest, Vector3::zeros())]);
            let mut is_scaled = false;
            for (map, origin) in maps.filter(|(map, _)| is_off(map)) {
                *map = unscaled(map, &origin);
                is_scaled = true;
            }
            if is_scaled {
                joints.push(self.skeleton.names[joint].clone());
            }
        }
        (!joints.is_empty()).then_some(Warning::IdleScaled { joints })
    }
}

/// Gives the rigid map that turns as a map does, and takes a joint's origin to the same place.
fn unscaled(map: &Matrix3x4, origin: &Vector3<f64>) -> Matrix3x4 {
    let (linear, offset) = parts(map);
    let turn = polar(&linear).map_or(Matrix3::identity(), |(turn, _)| turn);
    to_rows(&joined(&turn, &(linear * origin + offset - turn * origin)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::testing::triangle;

    #[test]
    fn joints_that_carry_a_weighted_one_are_not_idle() {
        let parents = [None, Some(0), Some(1), Some(1), Some(3)];
        let weights = [[0.0, 0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0, 0.0]];
        let found = idle(Some(weights.as_flattened()), &parents);
        assert_eq!(found, [false, false, false, true, true]);
        assert_eq!(idle(None, &parents), [false; 5]);
    }

    #[test]
    fn an_idle_joint_turns_and_moves_and_no_longer_scales() {
        let mut examples = triangle(1);
        let joints = examples.joint_len();
        let weights = |joint: usize| (0..joints).map(|j| f64::from(u8::from(j == joint))).collect();
        let row: Vec<f64> = weights(0);
        examples.joint_weights = Some(row.repeat(examples.vertex_len()));
        let scaled = [[0.0, -2.0, 0.0, 1.0], [3.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0, 3.0]];
        examples.skeleton.rest[1].iter_mut().zip([0.5, 1.0, 0.0]).for_each(|(row, x)| row[3] = x);
        examples.transforms[1] = scaled;
        let warning = examples.unscale_idle_joints();
        let joints = vec![examples.skeleton.names[1].clone()];
        assert_eq!(warning, Some(Warning::IdleScaled { joints }));
        let found = examples.transforms[1];
        // A quarter turn about z, and (0.5, 1, 0) still becomes (-1, 3.5, 3).
        let expected = [[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 3.0], [0.0, 0.0, 1.0, 3.0]];
        let apart = found.as_flattened().iter().zip(expected.as_flattened());
        assert!(apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-12, "{found:?}");

        // A joint that moves a vertex keeps its scale.
        let row: Vec<f64> = weights(1);
        examples.joint_weights = Some(row.repeat(examples.vertex_len()));
        examples.transforms[1] = scaled;
        assert_eq!(examples.unscale_idle_joints(), None);
        assert_eq!(examples.transforms[1], scaled);
    }
}
