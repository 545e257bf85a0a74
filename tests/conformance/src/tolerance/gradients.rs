//! The tolerance of stage gradients: relative transforms, rotations, and gradients of the keys.

use super::inexact::{Inexact, Transform, product, seen_from};
use super::polar::{inverse_error, strains, turns};
use nalgebra::{Matrix3, Vector3};
use sinew_trainer::envelope::model::{EnvelopeModel, Key, movement, symmetric};
use sinew_trainer::numeric::affine::linear;
use sinew_trainer::numeric::so3;
use sinew_trainer::regression::arithmetic::{Arithmetic, U, gamma};
use std::f64::consts::PI;

/// Bounds the relative transforms: `[L_r⁻¹ L_j | L_r⁻¹ (t_j - t_r)]`. Three products a sum, and one
/// rounding of the difference: γ₄. The inverse is the transpose if no joint stretches.
pub fn relative(
    oracle: &EnvelopeModel,
    pose: &Inexact<Transform>,
    arithmetic: Arithmetic,
) -> Inexact<Transform> {
    let value = oracle.relative(&pose.value);
    let root = oracle.skeleton.root();
    let (map, map_error) = (&pose.value[root], &pose.error[root]);
    let inverse = match (oracle.stretch_ranges.is_some(), oracle.turns(&pose.value)[root]) {
        (false, _) => (linear(map).transpose(), linear(map_error).transpose()),
        (true, None) => (Matrix3::zeros(), Matrix3::zeros()),
        (true, Some(_)) => {
            let (map, error) = (linear(map), linear(map_error));
            let inverse = map.try_inverse().unwrap_or_default();
            (inverse, inverse_error(&map, &error, arithmetic).transpose())
        }
    };
    let error = pose.value.iter().zip(&pose.error).enumerate().map(|(joint, transform)| {
        if joint == root {
            return Transform::zeros();
        }
        seen_from((&inverse.0, &inverse.1), (map, map_error), transform)
    });
    Inexact { error: error.collect(), value }
}

/// Returns the transforms that the rotations come from: the pose if joints stretch, else the
/// relative transforms.
pub fn turning<'a>(
    oracle: &EnvelopeModel,
    pose: &'a Inexact<Transform>,
    relative: &'a Inexact<Transform>,
) -> &'a Inexact<Transform> {
    if oracle.stretch_ranges.is_some() { pose } else { relative }
}

/// Bounds the rotations θ = log(R_pᵀ R_j): one bound for the length of each error.
///
/// `rotation_error` bounds the error of the rotation. The slope of log is (|θ|/2)/sin(|θ|/2), at
/// most π/2. |v| has an error of 1.5u and a root, and so has its ratio to w. The arc tangent has
/// 2.1 ULP or 4.2u, including u for its division. The scale has the error of |v| again, a division
/// and a product. In total 7.2u|θ|, two roots and two divisions; here 8u. A hidden joint has 0, and
/// so has its child.
///
/// - `joints`: from [`turning`].
pub fn rotations(
    oracle: &EnvelopeModel,
    joints: &Inexact<Transform>,
    arithmetic: Arithmetic,
) -> Inexact<Vector3<f64>, f64> {
    let of_angle = (8 + 2 * arithmetic.root + 2 * arithmetic.division) as f64 * U;
    let value = oracle.rotations(&joints.value);
    let turns = turns(oracle, joints, arithmetic);
    let bound = |(joint, theta): (usize, &Vector3<f64>)| {
        let ((p, p_error), (q, q_error)) = (turns[oracle.skeleton.parents[joint]?]?, turns[joint]?);
        let (p, p_error) = (p.transpose(), p_error.transpose());
        let error = product((&p, &p_error), (&q, &q_error), 3);
        let half = theta.norm() / 2.0;
        let steepness = if half > 0.0 { half / half.sin() } else { 1.0 };
        Some(steepness * rotation_error(&(p * q), &error) + of_angle * theta.norm())
    };
    let error = value.iter().enumerate().map(|at| bound(at).unwrap_or(0.0)).collect();
    Inexact { error, value }
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
/// each time. If joints stretch, `Q_p = R_rᵀ R_p` is such a product too.
///
/// - `joints`: from [`turning`].
pub fn gradients(
    oracle: &EnvelopeModel,
    joints: &Inexact<Transform>,
    rotations: &Inexact<Vector3<f64>, f64>,
    arithmetic: Arithmetic,
) -> Inexact<Matrix3<f64>> {
    let stretches = oracle.stretch_ranges.is_some();
    let (turns, strains) = (turns(oracle, joints, arithmetic), strains(oracle, joints));
    let bound = |key: &Key| {
        let factors = oracle.factors(key, &joints.value, &rotations.value);
        let turn = |matrix: &Matrix3<f64>, joint: usize, angles: &Vector3<f64>| {
            let theta = rotations.value[joint].abs();
            let from_product = (matrix.abs() * theta * gamma(3)).norm();
            let from_theta = matrix.norm() * rotations.error[joint] * (1.0 + gamma(3));
            exponential(angles, from_product + from_theta, arithmetic)
        };
        let above = oracle.skeleton.parents[key.joint];
        let moved = |theta: &dyn Fn(usize) -> Vector3<f64>, strain: [f64; 6]| {
            movement(&theta(key.joint), &above.map_or(Vector3::zeros(), theta), &strain)
        };
        let of_strain = |strain: [f64; 6]| if stretches { strain } else { [0.0; 6] };
        let own_strain = of_strain(strains.value[key.joint].abs().into());
        let strain_error = of_strain(strains.error[key.joint].into());
        let most = moved(&|joint| rotations.value[joint].abs(), own_strain);
        let error = moved(&|joint| Vector3::repeat(rotations.error[joint]), strain_error);
        // Two or four sums of three, added up; then 1 is added on the diagonal.
        let rounding = gamma(if stretches { 5 } else { 4 });
        let shear = most * rounding + error * (1.0 + rounding);
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
            let (own, own_error) = turns[parent].unwrap_or_default();
            let of_parent = if stretches {
                let (root, root_error) = turns[oracle.skeleton.root()].unwrap_or_default();
                let (root, root_error) = (root.transpose(), root_error.transpose());
                product((&root, &root_error), (&own, &own_error), 3)
            } else {
                own_error
            };
            apply(factors.parent, of_parent);
        }
        error
    };
    let error = oracle.keys().iter().map(bound).collect();
    Inexact { error, value: oracle.gradients(&joints.value, &rotations.value) }
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
