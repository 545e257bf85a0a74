//! Keys: P gradient sequences whose blends move every triangle's edges (METHOD §1.7.2, S3 §3.2). Each key has a
//! predictor: rotation (METHOD §1.4) times scale and shear (METHOD §1.5).

use super::Method;
use super::proxies::Proxies;
use super::rotation::{self, KeyChoice};
use super::surface::{Surface, edge_frame};
use crate::envelope::lbs::blend::{Alternation, Blend, Items, Weights};
use crate::envelope::lbs::poses::Poses;
use crate::envelope::model::{Key, Movement, Shear, movement, symmetric};
use crate::examples::Importance;
use crate::numeric::so3;
use crate::progress::Progress;
use faer::Mat;
use nalgebra::{DMatrix, Matrix3, SymmetricEigen, Vector3, Vector6};

/// Weight of n̂ as a third edge, which makes D_l unique if the supporting triangles are coplanar.
const NORMAL_WEIGHT: f64 = 0.1;
/// Name of the progress step.
const STEP: &str = "keys";
const ALTERNATION: Alternation = Alternation { choices: 3, every: 1, rounds: 0, momentum: 0.0 };
/// Ridge on H, in squared radians per example.
const RIDGE: f64 = 1e-3;
/// Ridge on H with a free bias. S3 has no ridge; this small ridge only determines entries without examples.
const SINGULAR: f64 = 1e-9;

/// Fitted keys.
pub struct Keys {
    /// Weights β of each triangle on at most K keys.
    pub weights: Weights,
    /// Gradients D_l on the trajectory basis, r x 3P.
    gradients: Mat<f64>,
    /// RMS error of the edges over triangles and training frames.
    pub rms: f64,
}

/// A key, and the choice of its joints.
#[derive(Clone, Debug)]
pub struct GradientPredictor {
    /// `D(q) = Q_p exp(u W θ_b) [exp(u' W' θ_c)] S(q)`.
    pub key: Key,
    /// Parent of b.
    pub parent: Option<usize>,
    /// Bias B, added to S(q); 0 except in a published fit.
    pub bias: Matrix3<f64>,
    /// Joints of the key, and the errors of all joints.
    pub choice: KeyChoice,
}

/// Fits keys to the edges of a surface. The linear parts of the proxies are the start.
pub fn fit(
    surface: &Surface<'_>,
    proxies: &Proxies,
    influences: usize,
    progress: &dyn Progress,
) -> Keys {
    progress.step(STEP, ALTERNATION.count());
    let y = edge_targets(surface);
    let counts: Vec<f64> =
        (0..surface.triangles.len()).map(|t| surface.triangle_importance(t)).collect();
    let importance = Importance::by(Some(&counts));
    let items = Items::new([3, 3], edge_rows(surface), &y, importance);
    let start = Mat::from_fn(surface.vertices.nrows(), 3 * proxies.len(), |k, column| {
        proxies.maps[(k, 4 * (column / 3) + column % 3)]
    });
    let Blend { weights, maps, error } =
        ALTERNATION.blend(&items, start, influences, || progress.advance(1));
    let edges = (2 * surface.triangles.len() * surface.frames).max(1) as f64;
    Keys { weights, gradients: maps, rms: (error / edges).sqrt() }
}

impl Keys {
    /// Returns the gradients of each of the P keys in n frames.
    ///
    /// - `basis`: trajectories of the basis, 3n x r.
    pub fn sequences(&self, basis: &Mat<f64>) -> Vec<Vec<Matrix3<f64>>> {
        let of = |key: usize| {
            let stacked = basis * self.gradients.subcols(3 * key, 3);
            let at = |frame: usize| Matrix3::from_fn(|r, c| stacked[(3 * frame + r, c)]);
            (0..stacked.nrows() / 3).map(at).collect()
        };
        (0..self.gradients.ncols() / 3).map(of).collect()
    }
}

impl GradientPredictor {
    /// Fits a predictor to a sequence of gradients.
    ///
    /// - `parents`: of the joints, J.
    /// - `gradients`: relative to the root, one per pose.
    pub fn fit(
        poses: &Poses,
        parents: &[Option<usize>],
        gradients: &[Matrix3<f64>],
        method: Method,
    ) -> Self {
        let (rotations, stretches): (Vec<_>, Vec<_>) =
            polar_sequence(gradients).into_iter().unzip();
        let (mut key, choice) = rotation::fit(poses, &rotations, method);
        let (parent, stretches) = (parents[key.joint], stretches.into_iter());
        let biased = method == Method::Published;
        let (shear, bias) = fit_stretch(poses, key.joint, parent, stretches, biased);
        key.shear = shear;
        Self { key, parent, bias, choice }
    }

    /// Returns this predictor without scale and shear.
    #[must_use]
    pub fn without_shear(&self) -> Self {
        let key = Key { shear: Shear::zeros(), ..self.key.clone() };
        Self { key, bias: Matrix3::zeros(), ..self.clone() }
    }

    /// Predicts the gradient of a pose, relative to the root.
    pub fn predict(&self, poses: &Poses, pose: usize) -> Matrix3<f64> {
        let parent = *poses.parent_rotation(pose, self.key.joint);
        let angle = |joint| poses.angle(pose, joint);
        let strain = poses.strain(pose, self.key.joint);
        let mut factors = self.key.factors(parent, angle, self.parent, &strain);
        factors.stretch += self.bias;
        factors.gradient()
    }
}

/// Predicts the gradients of P keys in n poses: 3n x 3P; columns 3l..3l+3 belong to key l.
pub fn predict_stacked(predictors: &[GradientPredictor], poses: &Poses) -> Mat<f64> {
    let mut out = Mat::zeros(3 * poses.len(), 3 * predictors.len());
    for (l, predictor) in predictors.iter().enumerate() {
        for pose in 0..poses.len() {
            let d = predictor.predict(poses, pose);
            for c in 0..3 {
                let column = &mut out.col_as_slice_mut(3 * l + c)[3 * pose..3 * pose + 3];
                column.copy_from_slice(d.column(c).as_slice());
            }
        }
    }
    out
}

/// Returns three rows per triangle: its two rest edges, and its rest normal times [`NORMAL_WEIGHT`].
fn edge_rows(surface: &Surface<'_>) -> Vec<f64> {
    let mut h = Vec::with_capacity(9 * surface.triangles.len());
    for (triangle, normal) in surface.triangles.iter().zip(&surface.rest_normals) {
        let frame = edge_frame(triangle.map(|v| &surface.rest[v]));
        h.extend_from_slice(&frame.as_slice()[..6]);
        h.extend((normal * NORMAL_WEIGHT).iter());
    }
    h
}

/// Returns the targets of the rows of [`edge_rows`]: posed edges and normals on the basis, r x 3T.
fn edge_targets(surface: &Surface<'_>) -> Mat<f64> {
    let mut y = Mat::zeros(surface.vertices.nrows(), 3 * surface.triangles.len());
    for (triangle, &[a, b, c]) in surface.triangles.iter().enumerate() {
        let first = surface.vertices.col(a);
        for (edge, corner) in [b, c].into_iter().enumerate() {
            y.col_mut(3 * triangle + edge).copy_from(surface.vertices.col(corner) - first);
        }
        let normal = faer::Scale(NORMAL_WEIGHT) * surface.normals.col(triangle);
        y.col_mut(3 * triangle + 2).copy_from(normal);
    }
    y
}

/// Splits a sequence of gradients into rotations and stretches.
///
/// A gradient of rank 0 or 1 has no unique rotation: it takes the rotation of the nearest frame that has one, or the
/// identity if no frame has one. Its stretch is the symmetric part of `Rᵀ D`.
pub fn polar_sequence(gradients: &[Matrix3<f64>]) -> Vec<(Matrix3<f64>, Matrix3<f64>)> {
    let split: Vec<_> = gradients.iter().map(so3::polar).collect();
    (0..gradients.len())
        .map(|i| {
            split[i].unwrap_or_else(|| {
                let nearest = (1..split.len())
                    .flat_map(|step| [i.checked_sub(step), Some(i + step)])
                    .flatten()
                    .find_map(|k| split.get(k).copied().flatten());
                let rotation = nearest.map_or(Matrix3::identity(), |(rotation, _)| rotation);
                let stretch = rotation.transpose() * gradients[i];
                (rotation, (stretch + stretch.transpose()) * 0.5)
            })
        })
        .collect()
}

/// Fits scale and shear to the stretches of one sequence: H, G and B of `S = I + B + sym(H [θ_b1; θ_b2] + G E_b1)`. With
/// B = 0 the rest pose gives S = I (METHOD §1.5); a free B is S3 §1.3. Rows are the entries xx, xy, xz, yy, yz, zz of S;
/// columns are θ_b1, θ_b2, and the strain of b1.
///
/// - `parent`: b2; `None` for the root.
/// - `biased`: fits B if true; else B is 0.
fn fit_stretch(
    poses: &Poses,
    joint: usize,
    parent: Option<usize>,
    stretches: impl Iterator<Item = Matrix3<f64>>,
    biased: bool,
) -> (Shear, Matrix3<f64>) {
    let x: Vec<_> = (0..poses.len()).map(|pose| features(poses, pose, joint, parent)).collect();
    let y: Vec<_> = stretches.map(|s| to_vector(&(s - Matrix3::identity()))).collect();
    // The best bias maps the mean of x to the mean of y; the centred values then need no bias.
    let share = if biased { 1.0 / x.len().max(1) as f64 } else { 0.0 };
    let mean_x = x.iter().sum::<Movement>() * share;
    let mean_y = y.iter().sum::<Vector6<f64>>() * share;
    let len = if poses.stretch() { Movement::zeros().len() } else { 6 };
    let mut gram = DMatrix::zeros(len, len);
    let mut right = DMatrix::zeros(6, len);
    for (x, y) in x.iter().zip(&y) {
        let x = (x - mean_x).rows(0, len).into_owned();
        gram += &x * x.transpose();
        right += (y - mean_y) * x.transpose();
    }
    // The Gram matrix is positive semidefinite; the ridge makes all eigenvalues positive.
    let eigen = SymmetricEigen::new(gram);
    let ridge = if biased { SINGULAR } else { RIDGE } * poses.len().max(1) as f64;
    let inverse = eigen.eigenvalues.map(|value| 1.0 / (value.max(0.0) + ridge));
    let q = eigen.eigenvectors;
    let solution = right * &q * DMatrix::from_diagonal(&inverse) * q.transpose();
    let mut shear = Shear::zeros();
    shear.columns_mut(0, len).copy_from(&solution);
    (shear, symmetric(&(mean_y - shear * mean_x)))
}

/// Returns `[θ_b1; θ_b2; E_b1]` of a pose.
fn features(poses: &Poses, pose: usize, joint: usize, parent: Option<usize>) -> Movement {
    let above = parent.map_or_else(Vector3::zeros, |p| *poses.angle(pose, p));
    movement(poses.angle(pose, joint), &above, &poses.strain(pose, joint))
}

/// Returns the entries xx, xy, xz, yy, yz, zz of a symmetric matrix.
fn to_vector(s: &Matrix3<f64>) -> Vector6<f64> {
    Vector6::new(s.m11, s.m12, s.m13, s.m22, s.m23, s.m33)
}

#[cfg(test)]
mod tests {
    use super::super::merge::MergeTree;
    use super::super::{ProxyCount, RotationalOptions, proxies};
    use super::*;
    use crate::envelope::lbs::training::Training;
    use crate::envelope::model::stretch;
    use crate::examples::demo::{DemoOptions, demo};
    use crate::numeric::basis::basis;
    use crate::progress::Silent;

    #[test]
    fn an_affine_motion_needs_one_key_and_it_is_the_gradient() {
        let examples = demo(&DemoOptions { vertices: 300, poses: 6, held_out: 0, seed: 1 });
        let Training { rest, triangles, .. } = Training::new(&examples, &Silent).unwrap();
        let affine = |frame: f64| {
            Matrix3::new(1.0, 0.2 * frame, 0.0, -0.1, 1.0 + 0.1 * frame, 0.3, 0.0, 0.0, 1.0)
        };
        let moved = Mat::from_fn(3 * 4, rest.len(), |row, vertex| {
            (affine((row / 3) as f64) * nalgebra::Vector3::from(rest[vertex]))[row % 3] + row as f64
        });
        let basis = basis(&moved);
        let surface = Surface::new(&rest, triangles, &moved, &basis, Importance::UNIFORM);
        let tree = MergeTree::build(&surface, || ());
        let options =
            RotationalOptions { proxies: ProxyCount::Fixed(1), ..RotationalOptions::default() };
        let joints = Mat::zeros(0, 0);
        let proxies = proxies::fit(&surface, &tree, &joints, &options, &Silent).unwrap();
        let keys = fit(&surface, &proxies, 4, &Silent);
        for (frame, found) in keys.sequences(&basis.vectors)[0].iter().enumerate() {
            // The third edge n̂ does not move by an affine map, so its small weight adds an error.
            assert!((found - affine(frame as f64)).amax() < 0.02, "{found}");
        }
        assert!(keys.rms < 2e-3, "{}", keys.rms);
    }

    #[test]
    fn keys_move_the_edges_of_a_bending_arm() {
        let examples = demo(&DemoOptions { vertices: 300, poses: 30, held_out: 0, seed: 1 });
        let Training { rest, triangles, trajectories, .. } =
            Training::new(&examples, &Silent).unwrap();
        let basis = basis(&trajectories);
        let surface = Surface::new(&rest, triangles, &trajectories, &basis, Importance::UNIFORM);
        let tree = MergeTree::build(&surface, || ());
        let with = |count| {
            let options = RotationalOptions {
                proxies: ProxyCount::Fixed(count),
                ..RotationalOptions::default()
            };
            let joints = Mat::zeros(0, 0);
            let proxies = proxies::fit(&surface, &tree, &joints, &options, &Silent).unwrap();
            fit(&surface, &proxies, 4, &Silent).rms
        };
        assert!(with(20) < 0.5 * with(5));
    }

    #[test]
    fn the_joint_and_the_residual_joint_of_a_synthetic_sequence_are_found() {
        let examples = demo(&DemoOptions { vertices: 200, poses: 80, held_out: 0, seed: 4 });
        let frames: Vec<usize> = (0..examples.frame_len()).collect();
        let poses = Poses::new(&examples, &frames);
        let ranges = poses.angle_ranges();
        let mut moving: Vec<usize> = (0..poses.joint_len()).filter(|&j| ranges[j] > 0.3).collect();
        let (joint, residual) = (moving.remove(0), moving.remove(0));
        let sequence: Vec<_> = (0..poses.len())
            .map(|i| {
                poses.parent_rotation(i, joint)
                    * so3::exp(&(poses.angle(i, joint) * 0.6))
                    * so3::exp(&(poses.angle(i, residual) * 0.3))
            })
            .collect();
        let parents = &examples.skeleton.parents;
        let fitted = GradientPredictor::fit(&poses, parents, &sequence, Method::Refined);
        let rms = |predicted: &dyn Fn(usize) -> Matrix3<f64>| {
            let sum: f64 =
                (0..poses.len()).map(|i| (predicted(i) - sequence[i]).norm_squared()).sum();
            (sum / poses.len() as f64).sqrt()
        };
        let error = rms(&|i| fitted.predict(&poses, i));
        let mut one_joint = fitted.clone();
        one_joint.key.residual = None;
        let alone = rms(&|i| one_joint.predict(&poses, i));
        assert!(error < 0.5 * alone, "{error} against {alone}");
        let used = [Some(fitted.key.joint), fitted.key.residual.map(|(j, _)| j)];
        assert!(used.contains(&Some(joint)) && used.contains(&Some(residual)), "{used:?}");
        let stacked = predict_stacked(std::slice::from_ref(&fitted), &poses);
        assert_eq!(stacked[(3 * 7 + 1, 2)], fitted.predict(&poses, 7)[(1, 2)]);
    }

    #[test]
    fn a_collapsed_gradient_takes_the_rotation_of_the_nearest_frame() {
        let turned = so3::exp(&Vector3::new(0.0, 0.0, 1.0));
        let split = polar_sequence(&[turned, Matrix3::zeros()]);
        assert!((split[1].0 - turned).amax() < 1e-12 && split[1].1.amax() == 0.0);
    }

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
        let (h, bias) =
            fit_stretch(&poses, joint, parents[joint], (0..poses.len()).map(truth), false);
        for pose in 0..poses.len() {
            let found = stretch(&h, &features(&poses, pose, joint, parents[joint]));
            assert!((found - truth(pose)).amax() < 5e-3, "pose {pose}");
        }
        assert_eq!((h * Movement::zeros(), bias), (Vector6::zeros(), Matrix3::zeros()));
        let offset = Matrix3::new(0.2, 0.05, 0.0, 0.05, -0.1, 0.03, 0.0, 0.03, 0.01);
        let stretches = (0..poses.len()).map(|pose| truth(pose) + offset);
        let (h, bias) = fit_stretch(&poses, joint, parents[joint], stretches, true);
        assert!((bias - offset).amax() < 1e-6, "{bias}");
        for pose in 0..poses.len() {
            let found = stretch(&h, &features(&poses, pose, joint, parents[joint]));
            assert!((found - truth(pose)).amax() < 1e-6, "pose {pose}");
        }
    }
}
