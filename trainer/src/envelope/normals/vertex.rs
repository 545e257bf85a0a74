//! One vertex in the training poses, and the fit of its tangent coefficients (METHOD §1.8).

use crate::bake::sections::half;
use crate::numeric::columns::solve_ridge;
use faer::Mat;
use nalgebra::Vector3;

/// Weight of a tangential residual; a residual along the true normal has weight 1. A tangential residual changes the
/// normal only if the images also lean out of the surface.
const TANGENTIAL: f64 = 0.09;
/// Ridge, as a share of the mean diagonal entry of the normal matrix.
const RIDGE: f64 = 1e-5;
/// Rounding error of a transform in single precision, in rest diagonals. Smaller differences between transforms do not
/// count.
const ROUNDING: f64 = 1e-7;
/// Visible error of a vertex's normals, RMS in radians: 1°.
pub(super) const VISIBLE: f64 = 0.0175;
/// Number of steps of a refinement.
const STEPS: usize = 12;
/// First damping of a refinement, as a share of the mean diagonal entry of the normal matrix.
const DAMPING: f64 = 1e-3;
/// Factor of the damping after a failed step; its inverse after a successful step.
const DAMPING_FACTOR: f64 = 8.0;
/// A step succeeds if the squared error falls below this share.
const GAIN: f64 = 0.999;

/// Tangent coefficients g, h of a vertex's influences, K; their sum is 0.
pub(super) type Coefficients = Vec<[f64; 2]>;

/// A vertex, in the poses where it has a true normal.
pub(super) struct PosedVertex {
    pub(super) poses: Vec<VertexPose>,
    /// `y_l - y_1` of each influence but the first, pose by pose.
    pub(super) differences: Vec<Vector3<f64>>,
    /// Number of free influences: all but the first, K - 1.
    pub(super) free: usize,
    /// Number of training poses, also those without a true normal.
    pub(super) pose_len: usize,
}

/// A vertex in one pose.
#[derive(Clone, Copy)]
pub(super) struct VertexPose {
    /// True unit normal.
    pub(super) normal: Vector3<f64>,
    /// Images of t and b under the blended transform.
    pub(super) blended: [Vector3<f64>; 2],
    /// True images of t and b, orthogonal to the normal; `None` if faces are folded onto each other, or span no plane
    /// at rest.
    pub(super) images: Option<[Vector3<f64>; 2]>,
}

impl VertexPose {
    /// Projects a vector onto the true tangent plane.
    fn tangential(&self, vector: Vector3<f64>) -> Vector3<f64> {
        vector - self.normal * self.normal.dot(&vector)
    }
}

impl PosedVertex {
    /// Fits coefficients, and rounds them to half precision. `None` if the error of their normals is visible and not
    /// smaller than the error of cofactor normals.
    ///
    /// - `unit`: length unit of the fit, in length units of the file.
    pub(super) fn fit(&self, unit: f64) -> Option<Coefficients> {
        let found = rounded(self.refined(self.linear()?), unit);
        // In a file any influence may be the first, whose coefficients are not stored.
        let fits = found.as_flattened().iter().all(|c| half(c / unit).is_finite());
        let cofactors = self.error(&vec![[0.0; 2]; self.free + 1]);
        (fits && self.error(&found) < cofactors.max(self.visible())).then_some(found)
    }

    /// Sums the squared angles, in radians, between the normals of some coefficients and the true normals.
    pub(super) fn error(&self, coefficients: &[[f64; 2]]) -> f64 {
        let angle = |(pose, [t, b]): (&VertexPose, [Vector3<f64>; 2])| {
            let found = t.cross(&b);
            let angle = found.cross(&pose.normal).norm().atan2(found.dot(&pose.normal));
            if found == Vector3::zeros() { std::f64::consts::PI } else { angle }
        };
        self.posed(coefficients).map(|(_, pose, axes)| angle((pose, axes)).powi(2)).sum()
    }

    /// Lists `y_l - y_1`, the pose, and the images of t and b under some coefficients, pose by pose.
    fn posed<'a>(
        &'a self,
        coefficients: &'a [[f64; 2]],
    ) -> impl Iterator<Item = (&'a [Vector3<f64>], &'a VertexPose, [Vector3<f64>; 2])> {
        self.poses.iter().enumerate().map(move |(number, pose)| {
            let differences = &self.differences[self.free * number..][..self.free];
            let image = |k: usize| {
                let others = coefficients.iter().skip(1);
                let added = differences.iter().zip(others).map(|(difference, c)| difference * c[k]);
                pose.blended[k] + added.sum::<Vector3<f64>>()
            };
            (differences, pose, [image(0), image(1)])
        })
    }

    /// Fits the images of t and b to the true images by least squares; `None` if no pose has true images.
    pub(super) fn linear(&self) -> Option<Coefficients> {
        let len = self.free;
        let (mut gram, mut right) = (Mat::zeros(len, len), Mat::zeros(len, 2));
        let mut any = false;
        for (number, pose) in self.poses.iter().enumerate() {
            let Some(images) = pose.images else { continue };
            any = len > 0;
            let differences = &self.differences[len * number..][..len];
            let residual = [0, 1].map(|k| images[k] - pose.blended[k]);
            for (a, own) in differences.iter().enumerate() {
                let counted =
                    own * TANGENTIAL + pose.normal * ((1.0 - TANGENTIAL) * pose.normal.dot(own));
                for (b, other) in differences[..=a].iter().enumerate() {
                    gram[(a, b)] += counted.dot(other);
                }
                for k in 0..2 {
                    right[(a, k)] += counted.dot(&residual[k]);
                }
            }
        }
        if !any {
            return None;
        }
        let mean = gram.diagonal().column_vector().sum() / len as f64;
        let found = solve_ridge(&mut gram, right, RIDGE * mean + self.rounding_ridge());
        Some(balanced((0..len).map(|a| [found[(a, 0)], found[(a, 1)]]).collect()))
    }

    /// Lowers the error and the misfit of the images by damped Gauss-Newton steps.
    fn refined(&self, start: Coefficients) -> Coefficients {
        // The error of the linear fit is invisible, and its coefficients are the gradients of the weights: keep them.
        if self.error(&start) <= self.visible() {
            return start;
        }
        let whole = |found: &Coefficients| self.error(found) + self.misfit(found);
        let (mut least, mut found, mut damping) = (whole(&start), start, DAMPING);
        for _ in 0..STEPS {
            let next = self.step(&found, damping);
            let of_next = whole(&next);
            if of_next < GAIN * least {
                (found, least) = (next, of_next);
                damping /= DAMPING_FACTOR;
            } else {
                damping *= DAMPING_FACTOR;
            }
        }
        found
    }

    /// Sums the squared tangential errors of the images of t and b, relative to the squares of the true images, times
    /// [`TANGENTIAL`]. Without this term the images could shrink to 0: the normals would be right in these poses and
    /// arbitrary in others.
    fn misfit(&self, coefficients: &[[f64; 2]]) -> f64 {
        let of_pose = |(_, pose, [t, b]): (&[Vector3<f64>], &VertexPose, [Vector3<f64>; 2])| {
            pose.images.map_or(0.0, |[u, v]| {
                let squares = [u - t, v - b].map(|off| pose.tangential(off).norm_squared());
                tangential_weight([u, v]) * (squares[0] + squares[1])
            })
        };
        self.posed(coefficients).map(of_pose).sum()
    }

    /// Returns the sum of squared angles at the visible error.
    fn visible(&self) -> f64 {
        VISIBLE * VISIBLE * self.poses.len() as f64
    }

    /// Returns the ridge that corresponds to rounding in single precision.
    fn rounding_ridge(&self) -> f64 {
        self.pose_len as f64 * ROUNDING * ROUNDING
    }

    /// Takes one Gauss-Newton step towards the true unit normals and images.
    fn step(&self, from: &[[f64; 2]], damping: f64) -> Coefficients {
        let len = 2 * self.free;
        let (mut gram, mut right) = (Mat::zeros(len, len), Mat::zeros(len, 1));
        // Derivatives of the unit normal with respect to each coefficient.
        let mut slopes = vec![Vector3::zeros(); len];
        for (differences, pose, [t, b]) in self.posed(from) {
            let length = t.cross(&b).norm();
            let Some(unit) = t.cross(&b).try_normalize(0.0) else { continue };
            let across = |slope: Vector3<f64>| (slope - unit * unit.dot(&slope)) / length;
            for (a, difference) in differences.iter().enumerate() {
                slopes[2 * a] = across(difference.cross(&b));
                slopes[2 * a + 1] = across(t.cross(difference));
            }
            let residual = pose.normal - unit;
            for (a, slope) in slopes.iter().enumerate() {
                for (b, other) in slopes[..=a].iter().enumerate() {
                    gram[(a, b)] += slope.dot(other);
                }
                right[(a, 0)] += slope.dot(&residual);
            }
            let Some(images) = pose.images else { continue };
            let weight = tangential_weight(images);
            for (k, found) in [t, b].into_iter().enumerate() {
                let residual = pose.tangential(images[k] - found);
                for (i, difference_i) in differences.iter().enumerate() {
                    let own = weight * pose.tangential(*difference_i);
                    for (j, difference_j) in differences[..=i].iter().enumerate() {
                        gram[(2 * i + k, 2 * j + k)] += own.dot(difference_j);
                    }
                    right[(2 * i + k, 0)] += own.dot(&residual);
                }
            }
        }
        let mean = gram.diagonal().column_vector().sum() / len as f64;
        let ridge = RIDGE * mean + self.rounding_ridge();
        for (a, c) in from[1..].as_flattened().iter().enumerate() {
            right[(a, 0)] -= ridge * c;
        }
        let change = solve_ridge(&mut gram, right, ridge + damping * mean);
        let next = |a: usize| [0, 1].map(|k| from[a + 1][k] + change[(2 * a + k, 0)]);
        balanced((0..self.free).map(next).collect())
    }
}

/// Returns the weight of a squared tangential error. One weight for both axes, so that a rotation of the axes in the
/// plane does not change the fit.
fn tangential_weight([u, v]: [Vector3<f64>; 2]) -> f64 {
    TANGENTIAL / (u.norm_squared() + v.norm_squared())
}

/// Rounds coefficients to half precision, as a file does. A coefficient beyond its range becomes infinite.
fn rounded(mut coefficients: Coefficients, unit: f64) -> Coefficients {
    coefficients.remove(0);
    let round = |c: f64| unit * f64::from(half(c / unit));
    balanced(coefficients.into_iter().map(|c| c.map(round)).collect())
}

/// Inserts the coefficients of the first influence: minus the sum of the others.
fn balanced(mut coefficients: Coefficients) -> Coefficients {
    let sum = |k: usize| coefficients.iter().map(|c| c[k]).sum::<f64>();
    coefficients.insert(0, [-sum(0), -sum(1)]);
    coefficients
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pose: the true normal, the true images, and `y_2 - y_1`.
    type Truth = (Vector3<f64>, [Vector3<f64>; 2], Vector3<f64>);

    /// Returns a vertex with two influences in some poses. Its blended transform keeps t and b.
    fn vertex(poses: &[Truth]) -> PosedVertex {
        let pose = |&(normal, images, _): &Truth| VertexPose {
            normal,
            blended: [Vector3::x(), Vector3::y()],
            images: Some(images),
        };
        PosedVertex {
            poses: poses.iter().map(pose).collect(),
            differences: poses.iter().map(|pose| pose.2).collect(),
            free: 1,
            pose_len: poses.len(),
        }
    }

    #[test]
    fn coefficients_that_leave_normals_worse_than_cofactors_are_not_kept() {
        // The true t is long; coefficients that lengthen t also tilt it towards the normal. The cofactor normal is
        // exact.
        let long = [Vector3::x() * 11.0, Vector3::y()];
        let posed = vertex(&[(Vector3::z(), long, Vector3::new(10.0, 0.0, 1.0))]);
        let linear = posed.linear().unwrap();
        assert!(posed.error(&linear) > 1e-3 && posed.error(&[[0.0; 2]; 2]) == 0.0);
        // The refinement removes the tilt.
        assert!(posed.fit(1.0).is_none_or(|found| posed.error(&found) <= posed.visible()));
        // A vertex whose faces are folded in every pose has no coefficients.
        let mut folded = posed;
        folded.poses.iter_mut().for_each(|pose| pose.images = None);
        assert!(folded.linear().is_none() && folded.fit(1.0).is_none());
    }

    #[test]
    fn a_refinement_minimises_angles_and_relative_lengths() {
        // Two poses with different best coefficients. The first pose has a long t, which dominates the linear fit.
        let pose = |length: f64, slope: f64, difference: [f64; 3]| {
            let along = Vector3::new(1.0, 0.0, slope).normalize();
            (along.cross(&Vector3::y()), [along * length, Vector3::y()], Vector3::from(difference))
        };
        let poses = [pose(10.0, 0.2, [10.0, 0.0, 1.0]), pose(1.0, 0.6, [0.0, 0.0, 1.0])];
        let posed = vertex(&poses);
        let whole = |g: f64| -> f64 {
            let of_pose = |&(normal, [image, _], difference): &Truth| {
                let t = Vector3::x() + difference * g;
                // The image of b has length 1.
                let off = (image - t).cross(&normal).norm_squared() / (image.norm_squared() + 1.0);
                t.cross(&Vector3::y()).angle(&normal).powi(2) + 0.09 * off
            };
            poses.iter().map(of_pose).sum()
        };
        let [linear, found] =
            [posed.linear().unwrap(), posed.fit(1.0).unwrap()].map(|found| found[1][0]);
        let least =
            (0..4000).map(|k| whole(f64::from(k) * 1e-3 - 1.0)).fold(f64::INFINITY, f64::min);
        assert!(whole(found) < 1.01 * least && whole(linear) > 1.1 * least, "{linear} {found}");
    }
}
