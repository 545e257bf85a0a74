//! One vertex in the poses of a training, and the tangent coefficients that its normals ask for (METHOD §1.8).

use crate::bake::sections::half;
use crate::numeric::columns::solve_ridge;
use faer::Mat;
use nalgebra::Vector3;

/// Weight of a residual square to the true normal, against 1 along it. The first changes a normal only through the
/// axes' lean in the surface.
const BESIDE: f64 = 0.09;
/// Ridge, as a share of the mean diagonal.
const RIDGE: f64 = 1e-5;
/// What transforms disagree by in single precision, in diagonals: less than that is not built on.
const UNSEEN: f64 = 1e-7;
/// Error of a vertex's normals that is seen, RMS in radians: 1°.
pub(super) const SEEN: f64 = 0.0175;
/// Steps of a refinement.
const STEPS: usize = 12;
/// First damping of a refinement, as a share of the mean diagonal.
const DAMPING: f64 = 1e-3;
/// Factor of the damping after a step that fails; its inverse after one that succeeds.
const HARDER: f64 = 8.0;
/// A step succeeds if it leaves less than this share of the squared error.
const GAIN: f64 = 0.999;

/// Tangent coefficients g, h of a vertex's influences, K, of sum 0.
pub(super) type Coefficients = Vec<[f64; 2]>;

/// A vertex in the poses that have a true normal for it.
pub(super) struct PosedVertex {
    pub(super) poses: Vec<VertexPose>,
    /// `y_l - y_K` of each pose and, in it, of each influence but the last.
    pub(super) apart: Vec<Vector3<f64>>,
    /// Number of influences without the last, K - 1.
    pub(super) free: usize,
    /// Number of all poses.
    pub(super) pose_len: usize,
}

/// A vertex in one pose.
#[derive(Clone, Copy)]
pub(super) struct VertexPose {
    /// True unit normal.
    pub(super) normal: Vector3<f64>,
    /// Images of t and b by the blended transform alone.
    pub(super) blended: [Vector3<f64>; 2],
    /// True images of t and b, square to the normal; `None` where faces are folded onto each other, or at rest span no
    /// plane.
    pub(super) images: Option<[Vector3<f64>; 2]>,
}

impl VertexPose {
    /// Returns the part of a vector in the true tangent plane.
    fn beside(&self, vector: Vector3<f64>) -> Vector3<f64> {
        vector - self.normal * self.normal.dot(&vector)
    }
}

impl PosedVertex {
    /// Fits coefficients, and rounds them to half precision. `None` where their normals have a visible error, and not a
    /// smaller one than those by cofactors.
    ///
    /// - `unit`: of the fit's lengths, in those of the file.
    pub(super) fn fit(&self, unit: f64) -> Option<Coefficients> {
        let found = held(self.refined(self.linear()?), unit);
        let cofactors = self.error(&vec![[0.0; 2]; self.free + 1]);
        (self.error(&found) < cofactors.max(self.seen())).then_some(found)
    }

    /// Sums the squared angles, in radians, between the normals by some coefficients and the true ones.
    pub(super) fn error(&self, coefficients: &[[f64; 2]]) -> f64 {
        let angle = |(pose, [t, b]): (&VertexPose, [Vector3<f64>; 2])| {
            let found = t.cross(&b);
            let angle = found.cross(&pose.normal).norm().atan2(found.dot(&pose.normal));
            if found == Vector3::zeros() { std::f64::consts::PI } else { angle }
        };
        self.posed(coefficients).map(|(_, pose, axes)| angle((pose, axes)).powi(2)).sum()
    }

    /// Lists the poses, `y_l - y_K` in each, and the images of t and b by some coefficients.
    fn posed<'a>(
        &'a self,
        coefficients: &'a [[f64; 2]],
    ) -> impl Iterator<Item = (&'a [Vector3<f64>], &'a VertexPose, [Vector3<f64>; 2])> {
        self.poses.iter().enumerate().map(move |(number, pose)| {
            let apart = &self.apart[self.free * number..][..self.free];
            let image = |k: usize| {
                let added = apart.iter().zip(coefficients).map(|(apart, c)| apart * c[k]);
                pose.blended[k] + added.sum::<Vector3<f64>>()
            };
            (apart, pose, [image(0), image(1)])
        })
    }

    /// Fits the images of t and b to the true ones, by least squares; `None` where no pose has them.
    pub(super) fn linear(&self) -> Option<Coefficients> {
        let len = self.free;
        let (mut gram, mut right) = (Mat::zeros(len, len), Mat::zeros(len, 2));
        let mut any = false;
        for (number, pose) in self.poses.iter().enumerate() {
            let Some(images) = pose.images else { continue };
            any = len > 0;
            let apart = &self.apart[len * number..][..len];
            let left = [0, 1].map(|k| images[k] - pose.blended[k]);
            for (a, own) in apart.iter().enumerate() {
                let counted = own * BESIDE + pose.normal * ((1.0 - BESIDE) * pose.normal.dot(own));
                for (b, other) in apart[..=a].iter().enumerate() {
                    gram[(a, b)] += counted.dot(other);
                }
                for k in 0..2 {
                    right[(a, k)] += counted.dot(&left[k]);
                }
            }
        }
        if !any {
            return None;
        }
        let mean = gram.diagonal().column_vector().sum() / len as f64;
        let found = solve_ridge(&mut gram, right, RIDGE * mean + self.unseen());
        Some(balanced((0..len).map(|a| [found[(a, 0)], found[(a, 1)]]).collect()))
    }

    /// Lowers the error and the misfit of the images by damped Gauss-Newton steps.
    fn refined(&self, start: Coefficients) -> Coefficients {
        // Below, the linear fit is as good, and its coefficients are the gradients of the weights.
        if self.error(&start) <= self.seen() {
            return start;
        }
        let whole = |found: &Coefficients| self.error(found) + self.misfit(found);
        let (mut least, mut found, mut damping) = (whole(&start), start, DAMPING);
        for _ in 0..STEPS {
            let next = self.step(&found, damping);
            let of_next = whole(&next);
            if of_next < GAIN * least {
                (found, least) = (next, of_next);
                damping /= HARDER;
            } else {
                damping *= HARDER;
            }
        }
        found
    }

    /// Sums the squared errors of the images of t and b in the true tangent plane, as a share of the true images' squares,
    /// times [`BESIDE`]. Images that shrink to nothing would have the right normal in these poses, and any in others.
    fn misfit(&self, coefficients: &[[f64; 2]]) -> f64 {
        let of_pose = |(_, pose, [t, b]): (&[Vector3<f64>], &VertexPose, [Vector3<f64>; 2])| {
            pose.images.map_or(0.0, |[u, v]| {
                let beside = [u - t, v - b].map(|off| pose.beside(off).norm_squared());
                beside_weight([u, v]) * (beside[0] + beside[1])
            })
        };
        self.posed(coefficients).map(of_pose).sum()
    }

    /// Sum of squared angles below the visible error.
    fn seen(&self) -> f64 {
        SEEN * SEEN * self.poses.len() as f64
    }

    /// Ridge by what single precision rounds.
    fn unseen(&self) -> f64 {
        self.pose_len as f64 * UNSEEN * UNSEEN
    }

    /// Takes one Gauss-Newton step towards the true unit normals and images.
    fn step(&self, from: &[[f64; 2]], damping: f64) -> Coefficients {
        let len = 2 * self.free;
        let (mut gram, mut right) = (Mat::zeros(len, len), Mat::zeros(len, 1));
        // Of the unit normal, by each coefficient.
        let mut slopes = vec![Vector3::zeros(); len];
        for (apart, pose, [t, b]) in self.posed(from) {
            let length = t.cross(&b).norm();
            let Some(unit) = t.cross(&b).try_normalize(0.0) else { continue };
            let across = |slope: Vector3<f64>| (slope - unit * unit.dot(&slope)) / length;
            for (a, apart) in apart.iter().enumerate() {
                slopes[2 * a] = across(apart.cross(&b));
                slopes[2 * a + 1] = across(t.cross(apart));
            }
            let left = pose.normal - unit;
            for (a, slope) in slopes.iter().enumerate() {
                for (b, other) in slopes[..=a].iter().enumerate() {
                    gram[(a, b)] += slope.dot(other);
                }
                right[(a, 0)] += slope.dot(&left);
            }
            let Some(images) = pose.images else { continue };
            let weight = beside_weight(images);
            for (k, found) in [t, b].into_iter().enumerate() {
                let left = pose.beside(images[k] - found);
                for (i, apart_i) in apart.iter().enumerate() {
                    let own = weight * pose.beside(*apart_i);
                    for (j, apart_j) in apart[..=i].iter().enumerate() {
                        gram[(2 * i + k, 2 * j + k)] += own.dot(apart_j);
                    }
                    right[(2 * i + k, 0)] += own.dot(&left);
                }
            }
        }
        let mean = gram.diagonal().column_vector().sum() / len as f64;
        let ridge = RIDGE * mean + self.unseen();
        for (a, c) in from[..self.free].as_flattened().iter().enumerate() {
            right[(a, 0)] -= ridge * c;
        }
        let by = solve_ridge(&mut gram, right, ridge + damping * mean);
        let moved = |a: usize| [0, 1].map(|k| from[a][k] + by[(2 * a + k, 0)]);
        balanced((0..self.free).map(moved).collect())
    }
}

/// Weight of a squared length beside the true normal, so that axes turned in the plane count alike.
fn beside_weight([u, v]: [Vector3<f64>; 2]) -> f64 {
    BESIDE / (u.norm_squared() + v.norm_squared())
}

/// Rounds coefficients as a file does; what half precision cannot hold becomes infinite.
fn held(mut coefficients: Coefficients, unit: f64) -> Coefficients {
    coefficients.pop();
    let round = |c: f64| unit * f64::from(half(c / unit));
    balanced(coefficients.into_iter().map(|c| c.map(round)).collect())
}

/// Adds the last influence's coefficients: minus the sum of the others'.
fn balanced(mut coefficients: Coefficients) -> Coefficients {
    let sum = |k: usize| coefficients.iter().map(|c| c[k]).sum::<f64>();
    let of_last = [-sum(0), -sum(1)];
    coefficients.push(of_last);
    coefficients
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pose: the true normal, the true images, and `y_1 - y_2`.
    type Truth = (Vector3<f64>, [Vector3<f64>; 2], Vector3<f64>);

    /// A vertex of two influences, whose blended transform alone leaves t and b as they are, in some poses.
    fn vertex(poses: &[Truth]) -> PosedVertex {
        let pose = |&(normal, images, _): &Truth| VertexPose {
            normal,
            blended: [Vector3::x(), Vector3::y()],
            images: Some(images),
        };
        PosedVertex {
            poses: poses.iter().map(pose).collect(),
            apart: poses.iter().map(|pose| pose.2).collect(),
            free: 1,
            pose_len: poses.len(),
        }
    }

    #[test]
    fn coefficients_that_leave_normals_worse_than_cofactors_are_not_kept() {
        // The images ask for a long t, which only a lean towards the normal gives; by cofactors the normal is right.
        let long = [Vector3::x() * 11.0, Vector3::y()];
        let posed = vertex(&[(Vector3::z(), long, Vector3::new(10.0, 0.0, 1.0))]);
        let linear = posed.linear().unwrap();
        assert!(posed.error(&linear) > 1e-3 && posed.error(&[[0.0; 2]; 2]) == 0.0);
        // The refinement takes the lean back.
        assert!(posed.fit(1.0).is_none_or(|found| posed.error(&found) <= posed.seen()));
        // There are none for a vertex whose faces are folded in every pose.
        let mut folded = posed;
        folded.poses.iter_mut().for_each(|pose| pose.images = None);
        assert!(folded.linear().is_none() && folded.fit(1.0).is_none());
    }

    #[test]
    fn a_refinement_counts_directions_and_shares_of_lengths() {
        // Two poses that ask for different coefficients. The first, of a long t, counts most in the linear fit.
        let pose = |length: f64, slope: f64, apart: [f64; 3]| {
            let along = Vector3::new(1.0, 0.0, slope).normalize();
            (along.cross(&Vector3::y()), [along * length, Vector3::y()], Vector3::from(apart))
        };
        let poses = [pose(10.0, 0.2, [10.0, 0.0, 1.0]), pose(1.0, 0.6, [0.0, 0.0, 1.0])];
        let posed = vertex(&poses);
        let whole = |g: f64| -> f64 {
            let of_pose = |&(normal, [image, _], apart): &Truth| {
                let t = Vector3::x() + apart * g;
                // The image of b is of length 1.
                let off = (image - t).cross(&normal).norm_squared() / (image.norm_squared() + 1.0);
                t.cross(&Vector3::y()).angle(&normal).powi(2) + 0.09 * off
            };
            poses.iter().map(of_pose).sum()
        };
        let [linear, found] =
            [posed.linear().unwrap(), posed.fit(1.0).unwrap()].map(|found| found[0][0]);
        let least =
            (0..4000).map(|k| whole(f64::from(k) * 1e-3 - 1.0)).fold(f64::INFINITY, f64::min);
        assert!(whole(found) < 1.01 * least && whole(linear) > 1.1 * least, "{linear} {found}");
    }
}
