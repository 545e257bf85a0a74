//! Joints: idle joints, the single root, and estimated rest origins.

use super::distortion::{RIGID, STRETCHES, deviation};
use super::{Examples, Matrix3x4, Skeleton, Split, Warning};
use crate::numeric::affine::{joined, parts, strain, to_rows};
use crate::numeric::so3::polar;
use nalgebra::{Matrix3, Vector3};

/// Least rotation (RMS, radians) relative to the parent that locates a joint's origin, per direction: a fraction of the
/// largest rotation, and a floor above f32 rounding.
const LEAST_TURN: (f64, f64) = (1e-3, 1e-5);

impl Examples {
    /// Removes scales that no fit needs: of whole frames, and of idle joints. Returns a warning for each.
    pub(crate) fn unscale(&mut self) -> impl Iterator<Item = Warning> + use<> {
        let of_frames = self.unscale_frames();
        of_frames.into_iter().chain(self.unscale_idle_joints())
    }

    /// Divides each frame by the uniform scale of the root, as a runtime does with the scale of an actor. Returns a
    /// warning with the number of scaled frames and the largest scale.
    fn unscale_frames(&mut self) -> Option<Warning> {
        let (joint_len, vertex_len) = (self.joint_len(), self.vertex_len());
        let root = self.skeleton.root();
        let (mut frames, mut most) = (0, 1.0);
        for frame in 0..self.transforms.len() / joint_len.max(1) {
            let pose = &mut self.transforms[frame * joint_len..][..joint_len];
            let Some(scale) = pose.get(root).and_then(uniform_scale) else { continue };
            pose.as_flattened_mut().as_flattened_mut().iter_mut().for_each(|x| *x /= scale);
            let posed = self.vertices.iter_mut().skip(frame * vertex_len).take(vertex_len);
            posed.for_each(|x| *x = x.map(|x| x / scale));
            frames += 1;
            if f64::abs(scale.ln()) > f64::abs(f64::ln(most)) {
                most = scale;
            }
        }
        let joint = self.skeleton.names.get(root)?.clone();
        (frames > 0).then_some(Warning::FramesScaled { joint, frames, most })
    }

    /// Removes the scale of idle joints, such as sockets; keeps their rotation and translation. Returns a warning with
    /// the names of the scaled joints.
    fn unscale_idle_joints(&mut self) -> Option<Warning> {
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
        (!joints.is_empty()).then_some(Warning::IdleScaled(joints))
    }

    /// Returns whether each joint stretches in a training frame, J.
    pub fn stretching_joints(&self) -> Vec<bool> {
        let mut stretching = vec![false; self.joint_len()];
        for frame in self.frames_of(Split::Train) {
            for (stretches, map) in stretching.iter_mut().zip(self.pose(frame)) {
                *stretches |= strain(&parts(map).0).iter().any(|x| x.abs() > STRETCHES);
            }
        }
        stretching
    }

    /// Returns whether each joint is further from rigid than [`RIGID`] in one of these frames, J.
    pub(crate) fn stretching_in(&self, frames: &[usize]) -> Vec<bool> {
        let stretches = |joint| {
            let mut maps = frames.iter().map(|&frame: &usize| &self.pose(frame)[joint]);
            maps.any(|map| deviation(map) > RIGID)
        };
        (0..self.joint_len()).map(stretches).collect()
    }

    /// Estimates the rest origins of joints without a rest position in the source, from the training frames. Call again
    /// after the training frames change.
    pub fn place_joints(&mut self) {
        for place in 0..self.skeleton.unplaced.len() {
            let joint = self.skeleton.unplaced[place];
            let origin = rest_origin(self, joint);
            self.skeleton.rest[joint].iter_mut().zip(origin).for_each(|(row, x)| row[3] = x);
        }
    }
}

/// Returns whether each joint is idle, J: neither the joint nor a descendant moves a vertex.
///
/// - `joint_weights`: painted weights, V x J; without weights no joint is idle.
/// - `parents`: parent of each joint, J.
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

/// Makes the first joint without a parent the parent of all other such joints. Returns all parents and the other roots.
pub(super) fn join_roots(
    names: &[String],
    mut parents: Vec<Option<usize>>,
    warnings: &mut Vec<Warning>,
) -> (Vec<Option<usize>>, Vec<usize>) {
    let roots: Vec<usize> = (0..parents.len()).filter(|&joint| parents[joint].is_none()).collect();
    let Some((&reference, others)) = roots.split_first() else { return (parents, roots) };
    if !others.is_empty() {
        let joints = roots.iter().map(|&root| names[root].clone()).collect();
        warnings.push(Warning::SeveralRoots(joints));
    }
    others.iter().for_each(|&root| parents[root] = Some(reference));
    (parents, others.to_vec())
}

/// Returns the scale of a map that scales all directions alike; `None` if the map is rigid or scales unevenly.
fn uniform_scale(map: &Matrix3x4) -> Option<f64> {
    let (linear, _) = parts(map);
    let products = linear.transpose() * linear;
    let square = products.trace() / 3.0;
    let uneven = (products - Matrix3::from_diagonal_element(square)).amax();
    let is_scaled = square.is_normal()
        && uneven <= 2.0 * STRETCHES * square
        && (square - 1.0).abs() > 2.0 * STRETCHES
        && linear.determinant() > 0.0;
    is_scaled.then(|| square.sqrt())
}

/// Returns the rigid map with the rotation of `map` that moves `origin` to the same place.
fn unscaled(map: &Matrix3x4, origin: &Vector3<f64>) -> Matrix3x4 {
    let (linear, offset) = parts(map);
    let turn = polar(&linear).map_or(Matrix3::identity(), |(turn, _)| turn);
    to_rows(&joined(&turn, &(linear * origin + offset - turn * origin)))
}

/// Estimates the rest origin of `joint`: the point that the joint's map and its parent's map move closest together, by
/// least squares over the training frames.
///
/// A hinge leaves the position along its axis undetermined, and a joint that never rotates leaves every position
/// undetermined. The estimate is then the candidate nearest to the centroid of the rest mesh. The root gets the
/// centroid; no result depends on this choice.
fn rest_origin(examples: &Examples, joint: usize) -> [f64; 3] {
    let centroid = Vector3::from(examples.centroid());
    let Some(parent) = examples.skeleton.parents[joint] else { return centroid.into() };

    let frames = examples.frames_of(Split::Train);
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for &frame in &frames {
        let pose = examples.pose(frame);
        let (turn, shift) = parts(&pose[joint]);
        let (parent_turn, parent_shift) = parts(&pose[parent]);
        let turn = turn - parent_turn;
        let gap = parent_shift - shift - turn * centroid;
        normal += turn.transpose() * turn / frames.len() as f64;
        right += turn.transpose() * gap / frames.len() as f64;
    }
    let eigen = normal.symmetric_eigen();
    let least = (LEAST_TURN.0.powi(2) * eigen.eigenvalues.max()).max(LEAST_TURN.1.powi(2));
    let offset = (0..3).filter(|&axis| eigen.eigenvalues[axis] > least).map(|axis| {
        let direction = eigen.eigenvectors.column(axis);
        direction * (direction.dot(&right) / eigen.eigenvalues[axis])
    });
    (centroid + offset.sum::<Vector3<f64>>()).into()
}

#[cfg(test)]
mod tests {
    use super::super::testing::triangle;
    use super::*;
    use nalgebra::Rotation3;

    #[test]
    fn ancestors_of_weighted_joints_are_not_idle() {
        let parents = [None, Some(0), Some(1), Some(1), Some(3)];
        let weights = [[0.0, 0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0, 0.0]];
        let found = idle(Some(weights.as_flattened()), &parents);
        assert_eq!(found, [false, false, false, true, true]);
        assert_eq!(idle(None, &parents), [false; 5]);
    }

    #[test]
    fn an_idle_joint_keeps_its_rigid_motion_and_loses_its_scale() {
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
        assert_eq!(warning, Some(Warning::IdleScaled(joints)));
        let found = examples.transforms[1];
        // A quarter turn about z that still moves (0.5, 1, 0) to (-1, 3.5, 3).
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

    const ORIGIN: Vector3<f64> = Vector3::new(0.3, -0.2, 5.0);

    fn turned_about_origin(turns: &[Vector3<f64>]) -> Examples {
        let mut examples = triangle(turns.len());
        for (frame, turn) in turns.iter().enumerate() {
            let turn = Rotation3::new(*turn);
            let shift = ORIGIN - turn * ORIGIN;
            examples.transforms[frame * 2 + 1] =
                [0, 1, 2].map(|row| [turn[(row, 0)], turn[(row, 1)], turn[(row, 2)], shift[row]]);
        }
        examples
    }

    #[test]
    fn a_ball_joint_turns_about_its_origin() {
        let turns = [Vector3::x(), Vector3::y(), Vector3::new(0.1, -0.4, 0.7)];
        let found = Vector3::from(rest_origin(&turned_about_origin(&turns), 1));
        assert!((found - ORIGIN).norm() < 1e-12, "{found}");
    }

    #[test]
    fn a_hinge_has_its_origin_nearest_to_the_centroid() {
        let turns = [Vector3::z() * 0.2, Vector3::z() * 1.4, Vector3::z() * -0.7];
        let found = Vector3::from(rest_origin(&turned_about_origin(&turns), 1));
        assert!((found - Vector3::new(ORIGIN.x, ORIGIN.y, 0.0)).norm() < 1e-12, "{found}");
    }

    #[test]
    fn held_out_frames_are_not_read() {
        let turns = [Vector3::x(), Vector3::y(), Vector3::z()];
        let mut examples = turned_about_origin(&turns);
        let mut noisy = examples.clone();
        examples.split[1] = Split::HeldOut;
        noisy.split[1] = Split::HeldOut;
        noisy.transforms[3] = [[9.0; 4]; 3];
        assert_eq!(rest_origin(&examples, 1), rest_origin(&noisy, 1));
    }

    #[test]
    fn a_joint_that_never_turns_sits_at_the_centroid() {
        let examples = triangle(3);
        assert_eq!(rest_origin(&examples, 0), [1.0 / 3.0, 1.0 / 3.0, 0.0]);
        assert_eq!(rest_origin(&examples, 1), [1.0 / 3.0, 1.0 / 3.0, 0.0]);
    }
}
