//! Rest origins of joints whose source does not give them.

use nalgebra::{Matrix3, Vector3};

use super::{Examples, Split};
use crate::numeric::affine::parts;

/// Directions in which a joint turns less than this (RMS, radians) against its parent carry no
/// information about its origin: a thousandth of the largest turn, and above single precision.
const LEAST_TURN: (f64, f64) = (1e-3, 1e-5);

impl Examples {
    /// Puts the joints of which the source does not say where they are at rest where the training frames have them.
    /// Whoever changes which frames train calls it anew.
    pub fn place_joints(&mut self) {
        for place in 0..self.skeleton.unplaced.len() {
            let joint = self.skeleton.unplaced[place];
            let origin = rest_origin(self, joint);
            self.skeleton.rest[joint].iter_mut().zip(origin).for_each(|(row, x)| row[3] = x);
        }
    }
}

/// Finds the rest origin of `joint`: the point that its maps and its parent's move together best
/// over the training frames, in least squares.
///
/// A hinge leaves the place along its axis open, a joint that never turns leaves all open: there
/// the point nearest to the centroid of the rest mesh is taken. The reference root gets the centroid
/// itself; nothing depends on it.
fn rest_origin(examples: &Examples, joint: usize) -> [f64; 3] {
    let centroid =
        examples.rest.iter().map(|&position| Vector3::from(position)).sum::<Vector3<f64>>()
            / examples.vertex_len() as f64;
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
    use nalgebra::Rotation3;

    use super::super::testing::triangle;
    use super::*;

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
