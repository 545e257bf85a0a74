//! The tolerance of stage gradients: relative transforms, rotations, and gradients of the keys.

use super::inexact::{Inexact, Transform, product, seen_from};
use nalgebra::{Matrix3, Vector3};
use sinew_trainer::envelope::model::{EnvelopeModel, Key, angles, symmetric};
use sinew_trainer::numeric::affine::linear;
use sinew_trainer::numeric::so3;
use sinew_trainer::regression::arithmetic::{Arithmetic, U, gamma};
use std::f64::consts::PI;

/// Bounds the relative transforms: `[Q_rᵀ Q_j | Q_rᵀ (t_j - t_r)]`. Three products a sum, and one
/// rounding of the difference: γ₄.
pub fn relative(oracle: &EnvelopeModel, pose: &Inexact<Transform>) -> Inexact<Transform> {
    let root = oracle.skeleton.root();
    let moving = (&pose.value[root], &pose.error[root]);
    let error = pose.value.iter().zip(&pose.error).enumerate().map(|(joint, transform)| {
        if joint == root { Transform::zeros() } else { seen_from(moving, transform) }
    });
    Inexact { error: error.collect(), value: oracle.relative(&pose.value) }
}

/// Bounds the rotations θ = log(Q_pᵀ Q_j): one bound for the length of each error.
///
/// `rotation_error` bounds the error of the rotation. The slope of log is (|θ|/2)/sin(|θ|/2), at
/// most π/2. |v| has an error of 1.5u and a root, and so has its ratio to w. The arc tangent has
/// 2.1 ULP or 4.2u, including u for its division. The scale has the error of |v| again, a division
/// and a product. In total 7.2u|θ|, two roots and two divisions; here 8u.
pub fn rotations(
    oracle: &EnvelopeModel,
    relative: &Inexact<Transform>,
    arithmetic: Arithmetic,
) -> Inexact<Vector3<f64>, f64> {
    let of_angle = (8 + 2 * arithmetic.root + 2 * arithmetic.division) as f64 * U;
    let value = oracle.rotations(&relative.value);
    let error =
        oracle.skeleton.parents.iter().zip(&value).enumerate().map(|(joint, (parent, theta))| {
            let Some(parent) = *parent else { return 0.0 };
            let turn = |j: usize| (linear(&relative.value[j]), linear(&relative.error[j]));
            let ((p, p_error), (q, q_error)) = (turn(parent), turn(joint));
            let (p, p_error) = (p.transpose(), p_error.transpose());
            let error = product((&p, &p_error), (&q, &q_error), 3);
            let half = theta.norm() / 2.0;
            let steepness = if half > 0.0 { half / half.sin() } else { 1.0 };
            steepness * rotation_error(&(p * q), &error) + of_angle * theta.norm()
        });
    Inexact { error: error.collect(), value }
}

/// Bounds the angle of the error of a rotation whose quaternion is computed from a matrix.
///
/// Let Δ be the Frobenius distance of the computed matrix from the rotation nearest to the exact
/// matrix: the error plus the exact matrix's own defect. The quaternion is linear in the matrix, up
/// to a length of at least 2 (four times its largest component, which is at least 1/2). So the
/// quaternion moves by at most √3 Δ, that is, the rotation by an angle of √3 Δ. Rounding of its
/// components adds 8u; the largest is a sum of four numbers up to 1. A tenth covers the second
/// order for Δ ≤ 0.05.
pub(super) fn rotation_error(rotation: &Matrix3<f64>, error: &Matrix3<f64>) -> f64 {
    let nearest = so3::polar(rotation).map_or(Matrix3::zeros(), |(rotation, _)| rotation);
    let delta = error.norm() + (rotation - nearest).norm();
    assert!(delta <= 0.05, "a joint is not rigid, or its error is not small: {delta}");
    1.1 * (3f64.sqrt() * delta + 8.0 * U)
}

/// Chooses the backend's representative of each rotation vector that may be at π within its error:
/// θ and θ - 2πθ/|θ| are one rotation.
pub fn same_branch(rotations: &mut Inexact<Vector3<f64>, f64>, found: &[[f32; 3]]) {
    for ((theta, error), found) in rotations.value.iter_mut().zip(&rotations.error).zip(found) {
        let other = *theta * (1.0 - 2.0 * PI / theta.norm());
        let found = Vector3::from(*found).map(f64::from);
        if theta.norm() + error >= PI && (other - found).norm() < (*theta - found).norm() {
            *theta = other;
        }
    }
}

/// Bounds the gradients: `D = Q_p exp(A θ_b) [exp(A' θ_c)] S`. Each product sums three products: γ₃
/// each time.
pub fn gradients(
    oracle: &EnvelopeModel,
    relative: &Inexact<Transform>,
    rotations: &Inexact<Vector3<f64>, f64>,
    arithmetic: Arithmetic,
) -> Inexact<Matrix3<f64>> {
    let bound = |key: &Key| {
        let factors = oracle.factors(key, &relative.value, &rotations.value);
        let turn = |matrix: &Matrix3<f64>, joint: usize, angles: &Vector3<f64>| {
            let theta = rotations.value[joint].abs();
            let from_product = (matrix.abs() * theta * gamma(3)).norm();
            let from_theta = matrix.norm() * rotations.error[joint] * (1.0 + gamma(3));
            exponential(angles, from_product + from_theta, arithmetic)
        };
        let error_of = |joint: usize| Vector3::repeat(rotations.error[joint]);
        let above = oracle.skeleton.parents[key.joint];
        let own = error_of(key.joint);
        let of_parent = above.map_or(Vector3::zeros(), error_of);
        let theta_error = angles(&own, &of_parent);
        let theta = |joint: usize| rotations.value[joint].abs();
        let theta = angles(&theta(key.joint), &above.map_or(Vector3::zeros(), theta));
        // Two sums of three and their sum; then 1 is added on the diagonal.
        let shear = theta * gamma(4) + theta_error * (1.0 + gamma(4));
        let diagonal = Matrix3::from_diagonal(&factors.stretch.diagonal().abs());
        let mut value = factors.stretch;
        let mut error = symmetric(&(key.shear.abs() * shear)) * (1.0 + U) + diagonal * U;
        let mut apply = |turn: Matrix3<f64>, turn_error: Matrix3<f64>| {
            error = product((&turn, &turn_error), (&value, &error), 3);
            value = turn * value;
        };
        if let (Some((joint, matrix)), Some(angles)) = (&key.residual, &factors.residual) {
            apply(so3::exp(angles), turn(matrix, *joint, angles));
        }
        apply(so3::exp(&factors.twist), turn(&key.twist, key.joint, &factors.twist));
        if let Some(parent) = above {
            apply(factors.parent, linear(&relative.error[parent]));
        }
        error
    };
    let error = oracle.keys().iter().map(bound).collect();
    Inexact { error, value: oracle.gradients(&relative.value, &rotations.value) }
}

/// Bounds the exponential `I + sin φ K + (1 - cos φ) K²`, φ = |ω|, where K is the cross product
/// with ω/φ and ω has an error of `omega_error`.
///
/// No entry changes by more than ω does. φ has an error of 1.5u (a sum of squares) and a root, here
/// 2u and a root. That rotates the matrix about its own axis by this error times φ(|K| + |K²|).
///
/// In the term of K, the sine has 2 ULP or 4u and the error of φ above; a division and two
/// operations follow: 8u, a root and a division. In the term of K², the versine has 4u and φ² has
/// 3u; a division and three operations follow: 10u and a division. For φ above π/2, the sine has an
/// error of 1.3e-7 and the versine of 2e-7 instead; 4u times min(φ, 1) and min(φ²/2, 2) cover these
/// as well. 1 is added on the diagonal: u.
fn exponential(
    omega: &Vector3<f64>,
    omega_error: f64,
    Arithmetic { division, root }: Arithmetic,
) -> Matrix3<f64> {
    let angle = omega.norm();
    let axis = if angle > 0.0 { omega / angle } else { Vector3::zeros() };
    let k = axis.cross_matrix();
    let (k, k2) = (k.abs(), (k * k).abs());
    let (sine, versine) = (angle.min(1.0), (angle * angle / 2.0).min(2.0));
    let of_angle = (2 + root) as f64 * angle;
    Matrix3::repeat(omega_error)
        + k * (U * (of_angle + (8 + root + division) as f64 * sine))
        + k2 * (U * (of_angle + (10 + division) as f64 * versine))
        + Matrix3::identity() * U
}
