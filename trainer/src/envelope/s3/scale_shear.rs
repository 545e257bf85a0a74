//! Scale and shear regression: `vec(S) - vec(I) = H [θ_b1; θ_b2]`, without bias, so that the rest
//! pose gives S = I (METHOD §1.5), or with the free bias of S3 §1.3.

use crate::envelope::lbs::poses::Poses;
use crate::envelope::model::{angles, symmetric};
use nalgebra::{Matrix3, Matrix6, SymmetricEigen, Vector3, Vector6};

/// Ridge on H, in squared radians per example.
const RIDGE: f64 = 1e-3;
/// The same beside a free bias. S3 has none: it is to decide only what no example tells.
const SINGULAR: f64 = 1e-9;

/// Fits H (rows are the entries xx, xy, xz, yy, yz, zz of S, columns θ_b1 and θ_b2) and B of `S = I + B + sym(H [θ_b1; θ_b2])` to the
/// stretches of one sequence.
///
/// - `parent`: b2, none for the root.
/// - `biased`: whether B is free, or zero.
pub fn fit(
    poses: &Poses,
    joint: usize,
    parent: Option<usize>,
    stretches: impl Iterator<Item = Matrix3<f64>>,
    biased: bool,
) -> (Matrix6<f64>, Matrix3<f64>) {
    let x: Vec<_> = (0..poses.len()).map(|pose| features(poses, pose, joint, parent)).collect();
    let y: Vec<_> = stretches.map(|s| to_vector(&(s - Matrix3::identity()))).collect();
    // The best bias carries the means into each other, so that what is left has none.
    let mean = |of: &[Vector6<f64>]| match biased {
        true => of.iter().sum::<Vector6<f64>>() / of.len().max(1) as f64,
        false => Vector6::zeros(),
    };
    let (mean_x, mean_y) = (mean(&x), mean(&y));
    let mut gram = Matrix6::zeros();
    let mut right = Matrix6::zeros();
    for (x, y) in x.iter().zip(&y) {
        let x = x - mean_x;
        gram += x * x.transpose();
        right += (y - mean_y) * x.transpose();
    }
    // The Gram matrix is symmetric with eigenvalues of zero or more, and the ridge lifts them.
    let eigen = SymmetricEigen::new(gram);
    let ridge = if biased { SINGULAR } else { RIDGE } * poses.len().max(1) as f64;
    let inverse = eigen.eigenvalues.map(|value| 1.0 / (value.max(0.0) + ridge));
    let q = eigen.eigenvectors;
    let h = right * q * Matrix6::from_diagonal(&inverse) * q.transpose();
    (h, symmetric(&(mean_y - h * mean_x)))
}

fn features(poses: &Poses, pose: usize, joint: usize, parent: Option<usize>) -> Vector6<f64> {
    let above = parent.map_or_else(Vector3::zeros, |p| *poses.angle(pose, p));
    angles(poses.angle(pose, joint), &above)
}

fn to_vector(s: &Matrix3<f64>) -> Vector6<f64> {
    Vector6::new(s.m11, s.m12, s.m13, s.m22, s.m23, s.m33)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::model::stretch;
    use crate::examples::demo::{DemoOptions, demo};

    #[test]
    fn a_stretch_linear_in_two_joints_is_recovered_and_so_is_a_free_bias() {
        let examples = demo(&DemoOptions { vertices: 200, poses: 60, held_out: 0, seed: 2 });
        let frames: Vec<usize> = (0..examples.frame_len()).collect();
        let poses = Poses::new(&examples, &frames);
        let parents = &examples.skeleton.parents;
        let spread = |j: usize| poses.angle_ranges()[j];
        let joint = (0..poses.joint_len())
            .find(|&j| spread(j) > 0.5 && parents[j].is_some_and(|p| spread(p) > 0.2))
            .unwrap();
        let truth = |pose: usize| {
            let bend: Vector3<f64> = *poses.angle(pose, joint);
            let above = *poses.angle(pose, parents[joint].unwrap());
            Matrix3::identity() + Matrix3::from_diagonal(&Vector3::new(bend.x, above.y, 0.0)) * 0.1
        };
        let (h, bias) = fit(&poses, joint, parents[joint], (0..poses.len()).map(truth), false);
        for pose in 0..poses.len() {
            let found = stretch(&h, &features(&poses, pose, joint, parents[joint]));
            assert!((found - truth(pose)).amax() < 5e-3, "pose {pose}");
        }
        assert_eq!((h * Vector6::zeros(), bias), (Vector6::zeros(), Matrix3::zeros()));
        let offset = Matrix3::new(0.2, 0.05, 0.0, 0.05, -0.1, 0.03, 0.0, 0.03, 0.01);
        let stretches = (0..poses.len()).map(|pose| truth(pose) + offset);
        let (h, bias) = fit(&poses, joint, parents[joint], stretches, true);
        assert!((bias - offset).amax() < 1e-6, "{bias}");
        for pose in 0..poses.len() {
            let found = stretch(&h, &features(&poses, pose, joint, parents[joint]));
            assert!((found - truth(pose)).amax() < 1e-6, "pose {pose}");
        }
    }
}
