//! Rotational regression: `ρ = u W θ_b` in the frame of b's parent (METHOD §1.4, S3 §1.2). Chooses the joint b that a
//! key follows and, if it lowers the error, a residual joint c.

use super::Method;
use crate::envelope::lbs::poses::Poses;
use crate::envelope::model::{Key, Shear};
use crate::numeric::so3;
use nalgebra::{Matrix3, Vector3};
use serde::Serialize;
use std::f64::consts::PI;

/// Maximum number of rounds in which ρ may change its representative (the branch at π).
const BRANCH_ROUNDS: usize = 3;
/// Strength of the preference for W near I, as a share of the first singular value.
const PREFERENCE: f64 = 1e-3;
/// Minimum gain of a mirroring u < 0, relative to Σ|ρ|².
const MIRROR_GAIN: f64 = 1e-6;
/// A residual joint is kept if its error is below this share of the error of one joint.
const RESIDUAL_GAIN: f64 = 0.98;
/// Maximum |u|. If a joint hardly moved in training, the fit explains noise by a large u. The surface would then spin
/// when the joint moves.
const MAX_SCALE: f64 = 4.0;

/// The matrix u W: a rotation and a scale.
#[derive(Clone, Copy, Debug)]
pub struct Twist {
    /// u, real.
    pub u: f64,
    /// W, a rotation.
    pub w: Matrix3<f64>,
    /// Σ |ρ - u W θ|² over the examples.
    pub error: f64,
}

/// Joints of a key, and the errors of all joints in their places.
#[derive(Clone, Debug, Serialize)]
pub struct KeyChoice {
    /// b, the joint that the key follows.
    pub joint: usize,
    /// c.
    pub residual_joint: Option<usize>,
    /// Σ|R - R_pred|² of each joint as b, J.
    pub errors: Vec<f64>,
    /// Σ|R - R_pred|² of each joint as c, J; the entry of b is the error without c.
    pub residual_errors: Vec<f64>,
}

/// Fits the rotation `R = Q_p exp(u W θ_b) [exp(u' W' θ_c)]` of a key: the joint, its twist and, if it lowers the error,
/// a residual joint. Tries every joint. Returns the key without shear.
///
/// A published fit finds W and u by coordinate descent from the start of S3, which reaches only u ≥ 0. Other fits find
/// the global optimum over both signs of u, and prefer W near I if the axes do not determine W.
///
/// - `rotations`: relative to the root, one per pose.
pub fn fit(poses: &Poses, rotations: &[Matrix3<f64>], method: Method) -> (Key, KeyChoice) {
    let joints = 0..poses.joint_len();
    let (mut twists, errors): (Vec<_>, Vec<_>) = joints
        .clone()
        .map(|b| {
            let bases = (0..poses.len()).map(|i| *poses.parent_rotation(i, b));
            candidate(poses, b, bases, rotations, method)
        })
        .unzip();
    let joint = least(&errors);
    let twist = twists[joint];
    let turn = |pose| so3::exp(&(twist * poses.angle(pose, joint)));
    let predicted = (0..poses.len()).map(|i| poses.parent_rotation(i, joint) * turn(i));
    let predicted: Vec<_> = predicted.collect();
    let mut residual_errors = vec![errors[joint]; errors.len()];
    for c in joints.filter(|&c| c != joint) {
        let start = predicted.iter().copied();
        (twists[c], residual_errors[c]) = candidate(poses, c, start, rotations, method);
    }
    let c = least(&residual_errors);
    let is_better = c != joint && residual_errors[c] < RESIDUAL_GAIN * errors[joint];
    let residual = is_better.then(|| (c, twists[c]));
    let residual_joint = is_better.then_some(c);
    let key = Key { joint, twist, residual, shear: Shear::zeros() };
    (key, KeyChoice { joint, residual_joint, errors, residual_errors })
}

/// Returns the index of the smallest error.
fn least(errors: &[f64]) -> usize {
    let order = errors.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
    order.map_or(0, |(index, _)| index)
}

/// Fits one joint after given base rotations, one per pose; returns u W and Σ|R - R_pred|².
fn candidate(
    poses: &Poses,
    joint: usize,
    bases: impl Iterator<Item = Matrix3<f64>> + Clone,
    rotations: &[Matrix3<f64>],
    method: Method,
) -> (Matrix3<f64>, f64) {
    let theta: Vec<_> = (0..poses.len()).map(|i| *poses.angle(i, joint)).collect();
    let mut rho: Vec<_> =
        bases.clone().zip(rotations).map(|(base, r)| so3::log(&(base.transpose() * r))).collect();
    let fit = fit_twist(&theta, &mut rho, method);
    let twist = fit.w * fit.u;
    let error = bases
        .zip(rotations)
        .zip(&theta)
        .map(|((base, r), angle)| (base * so3::exp(&(twist * angle)) - r).norm_squared())
        .sum();
    (twist, error)
}

/// Fits `ρ = u W θ`. For each ρ, the representative nearest to the prediction is chosen.
///
/// - `theta`, `rho`: radians, one per pose. `rho` receives the chosen representatives.
pub fn fit_twist(theta: &[Vector3<f64>], rho: &mut [Vector3<f64>], method: Method) -> Twist {
    let fit = |rho: &[Vector3<f64>]| {
        let moments = Moments::new(theta, rho);
        if moments.theta <= f64::MIN_POSITIVE || moments.rho <= f64::MIN_POSITIVE {
            return moments.zero();
        }
        if method != Method::Published {
            return moments.closed_form();
        }
        let lengths: f64 = theta.iter().zip(rho).map(|(t, r)| t.norm() * r.norm()).sum();
        moments.alternation(lengths / moments.theta)
    };
    let mut twist = fit(rho);
    for _ in 0..BRANCH_ROUNDS {
        let mut changed = false;
        for (angle, r) in theta.iter().zip(rho.iter_mut()) {
            let length = r.norm();
            if length == 0.0 {
                continue;
            }
            let other = *r - *r * (2.0 * PI / length);
            let predicted = twist.w * angle * twist.u;
            if (other - predicted).norm_squared() < (*r - predicted).norm_squared() {
                *r = other;
                changed = true;
            }
        }
        if !changed {
            break;
        }
        twist = fit(rho);
    }
    twist
}

struct Moments {
    /// Σ ρ θᵀ.
    m: Matrix3<f64>,
    /// Σ|θ|².
    theta: f64,
    /// Σ|ρ|².
    rho: f64,
}

impl Moments {
    fn new(theta: &[Vector3<f64>], rho: &[Vector3<f64>]) -> Self {
        Self {
            m: theta.iter().zip(rho).map(|(t, r)| r * t.transpose()).sum(),
            theta: theta.iter().map(Vector3::norm_squared).sum(),
            rho: rho.iter().map(Vector3::norm_squared).sum(),
        }
    }

    /// Returns the twist u = 0.
    fn zero(&self) -> Twist {
        Twist { u: 0.0, w: Matrix3::identity(), error: self.rho }
    }

    /// Fits u to a rotation W.
    ///
    /// - `side`: sign of u, 1 or -1; u is 0 if the best u has the other sign.
    fn scale(&self, w: Matrix3<f64>, side: f64) -> Twist {
        let trace = (w.transpose() * self.m).trace();
        let u = if trace * side > 0.0 { trace / self.theta } else { 0.0 };
        let u = u.clamp(-MAX_SCALE, MAX_SCALE);
        Twist { u, w, error: (self.rho - 2.0 * u * trace + u * u * self.theta).max(0.0) }
    }

    /// Finds the global optimum over both signs of u.
    fn closed_form(&self) -> Twist {
        let largest = self.m.singular_values()[0];
        let towards_identity = Matrix3::identity() * (PREFERENCE * largest);
        let positive = self.scale(procrustes(&(self.m + towards_identity), 1.0), 1.0);
        let negative = self.scale(procrustes(&(self.m - towards_identity), -1.0), -1.0);
        if negative.error < positive.error - MIRROR_GAIN * self.rho { negative } else { positive }
    }

    /// Fits W and u in turn from a start of u (S3 §1.2).
    fn alternation(&self, u: f64) -> Twist {
        const ROUNDS: usize = 100;
        let mut twist = Twist { u, ..self.zero() };
        for _ in 0..ROUNDS {
            let last = twist.error;
            twist = self.scale(procrustes(&(self.m * twist.u), 1.0), 1.0);
            if twist.u == 0.0 || last - twist.error <= 1e-14 * self.rho {
                break;
            }
        }
        twist
    }
}

/// Returns the rotation W that maximises (side = 1) or minimises (side = -1) tr(WᵀM).
fn procrustes(m: &Matrix3<f64>, side: f64) -> Matrix3<f64> {
    let svd = m.svd(true, true);
    let (Some(u), Some(vt)) = (svd.u, svd.v_t) else { return Matrix3::identity() };
    let sign = (u * vt).determinant().signum();
    u * Matrix3::from_diagonal(&Vector3::new(side, side, sign)) * vt
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    fn seeded(n: usize, seed: u64) -> Vec<Vector3<f64>> {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        (0..n).map(|_| Vector3::from_fn(|_, _| random.random_range(-1.0..1.0))).collect()
    }

    #[test]
    fn both_signs_of_u_and_its_axis_are_recovered() {
        let theta = seeded(40, 1);
        let axis = so3::exp(&Vector3::new(0.3, -0.2, 0.5));
        for u in [0.5, 1.0, -0.7] {
            let mut rho: Vec<_> = theta.iter().map(|t| axis * t * u).collect();
            let fit = fit_twist(&theta, &mut rho, Method::Refined);
            assert!((fit.u - u).abs() < 2e-3 && (fit.w - axis).amax() < 2e-3, "u {u}: {fit:?}");
        }
    }

    #[test]
    fn a_hinge_keeps_w_near_the_identity() {
        let theta: Vec<_> = (1..20).map(|i| Vector3::new(0.0, 0.0, 0.1 * f64::from(i))).collect();
        let mut rho: Vec<_> = theta.iter().map(|t| t * 0.5).collect();
        let fit = fit_twist(&theta, &mut rho, Method::Refined);
        assert!((fit.u - 0.5).abs() < 1e-12 && (fit.w - Matrix3::identity()).amax() < 1e-12);
    }

    #[test]
    fn a_counter_rotation_has_negative_u_only_if_it_lowers_the_error() {
        let theta = seeded(40, 2);
        let mut rho: Vec<_> = theta.iter().map(|t| -t * 0.4).collect();
        assert!(fit_twist(&theta, &mut rho, Method::Refined).u < 0.0);
        assert!(fit_twist(&theta, &mut rho, Method::Published).u >= 0.0);
        let hinge: Vec<_> = (1..20).map(|i| Vector3::new(0.0, 0.0, 0.1 * f64::from(i))).collect();
        let mut against: Vec<_> = hinge.iter().map(|t| -t * 0.4).collect();
        let fit = fit_twist(&hinge, &mut against, Method::Refined);
        assert!(fit.error < 1e-12, "a counter rotation of a hinge is exact with either sign");
    }

    #[test]
    fn no_rotation_gives_no_twist() {
        let still = vec![Vector3::zeros(); 5];
        let mut rho = seeded(5, 3);
        let fit = fit_twist(&still, &mut rho, Method::Refined);
        assert!(fit.u == 0.0 && fit.w == Matrix3::identity());
    }

    #[test]
    fn the_closed_form_is_never_worse_than_alternation() {
        for seed in 0..200 {
            let theta = seeded(12, 100 + seed);
            let mut rho = seeded(12, 900 + seed);
            let alternated = fit_twist(&theta, &mut rho.clone(), Method::Published);
            let closed = fit_twist(&theta, &mut rho, Method::Refined);
            // The preference for W near I costs at most its square, as a share of the error.
            let slack = 1e-5 * rho.iter().map(Vector3::norm_squared).sum::<f64>();
            assert!(closed.error <= alternated.error + slack, "seed {seed}");
        }
    }

    #[test]
    fn the_branch_at_pi_is_crossed() {
        let theta: Vec<_> = (0..24).map(|i| Vector3::new(0.1 * f64::from(i), 0.0, 0.0)).collect();
        let mut rho: Vec<_> = theta.iter().map(|t| so3::log(&so3::exp(&(t * 1.5)))).collect();
        let fit = fit_twist(&theta, &mut rho, Method::Refined);
        assert!((fit.u - 1.5).abs() < 1e-9 && fit.error < 1e-9, "{fit:?}");
    }
}
