//! The stages but those of the correction.

use faer::Mat;
use nalgebra::{Matrix3, Matrix3x4, SMatrix, Vector3};
use sinew_trainer::envelope::model::{
    EnvelopeModel, Key, Reconstruction, SkinModel, Vertex, angles, symmetric,
};
use sinew_trainer::envelope::oracle::stack;
use sinew_trainer::kernel::arithmetic::{Arithmetic, U, gamma};
use sinew_trainer::numeric::affine::{cofactors, linear};
use sinew_trainer::numeric::so3;
use std::f64::consts::PI;

/// Room for products that underflow: each loses less than 2⁻¹²⁶ even where subnormals are flushed,
/// and no coefficient that multiplies the loss passes 1e7.
pub const UNDERFLOW: f64 = 1e-30;
/// Rounding of f64 over some thousand operations on numbers near 1: for what is exact in real
/// arithmetic and is evaluated in f64 (METHOD §1.7).
pub const EXACT: f64 = 1e-12;
/// Likewise after solving a system of a condition near 1e4 in another way (METHOD §1.7.3).
pub const SOLVED: f64 = 1e-10;
/// Likewise through the pseudo-inverse of a system of a condition near 1e5.
pub const PSEUDO_SOLVED: f64 = 1e-9;
/// How many times longer than the skin's own box the bounds may be at rest: the proxies' boxes are
/// then its own, widened by the runtime's slack of 1e-5 and 2(K + 8)u of sums of up to four extents.
pub const BOUNDS_AT_REST: f64 = 1.001;
/// Likewise in trained poses. Each proxy's box is moved as a whole: a turn makes it up to √3 longer,
/// and a transform is free to stretch where no vertex of its box follows it alone. Not derived: a guard
/// against bounds that hold because they are enormous.
pub const BOUNDS_POSED: f64 = 6.0;

/// A transform from rest to posed.
pub type Transform = Matrix3x4<f64>;

/// Values, and how far from each, entry by entry, an f32 evaluation may be.
#[derive(Clone, Debug)]
pub struct Inexact<V, E = V> {
    /// The oracle's values.
    pub value: Vec<V>,
    /// Bounds of the error.
    pub error: Vec<E>,
}

impl<const R: usize, const C: usize> Inexact<SMatrix<f64, R, C>> {
    /// Takes values that the backend is given as they are.
    pub fn exact(value: Vec<SMatrix<f64, R, C>>) -> Self {
        Self { error: vec![SMatrix::zeros(); value.len()], value }
    }

    /// Takes values that the backend is given rounded to f32.
    pub fn rounded(value: Vec<SMatrix<f64, R, C>>) -> Self {
        Self { error: value.iter().map(|m| m.abs() * U).collect(), value }
    }
}

/// Gradients, first part: `[Q_rᵀ Q_j | Q_rᵀ (t_j - t_r)]`. Three products a sum, and one rounding
/// of the difference: γ₄.
pub fn relative(oracle: &EnvelopeModel, pose: &Inexact<Transform>) -> Inexact<Transform> {
    let root = oracle.skeleton.root();
    let moving = (&pose.value[root], &pose.error[root]);
    let error = pose.value.iter().zip(&pose.error).enumerate().map(|(joint, transform)| {
        if joint == root { Transform::zeros() } else { seen_from(moving, transform) }
    });
    Inexact { error: error.collect(), value: oracle.relative(&pose.value) }
}

/// `[A⁻¹ B]` of transforms, A taken as rigid.
pub(super) fn seen_from(
    (a, a_error): (&Transform, &Transform),
    (b, b_error): (&Transform, &Transform),
) -> Transform {
    let (inverse, inverse_error) = (linear(a).transpose(), linear(a_error).transpose());
    let (mut apart, mut apart_error) = (*b, *b_error);
    apart.column_mut(3).axpy(-1.0, &a.column(3), 1.0);
    apart_error.column_mut(3).axpy(1.0, &a_error.column(3), 1.0);
    product((&inverse, &inverse_error), (&apart, &apart_error), 4)
}

/// Gradients, second part: θ = log(Q_pᵀ Q_j); one bound for the length of each error.
///
/// Let Δ be the Frobenius distance of the computed matrix from the nearest rotation of the exact
/// one: the product's error and the exact one's own defect. The quaternion is read off linearly,
/// up to a length of at least 2 (its largest component is at least 1/2, times four): it moves by at
/// most √3 Δ, that is, the rotation by an angle of √3 Δ. Rounding of its components, the largest of
/// a sum of four numbers up to 1, adds 8u. log is as steep as (|θ|/2)/sin(|θ|/2), π/2 at the most.
/// |v| is off by 1.5u and a root, and so is its ratio to w; the arc tangent by 2.1 ULP or 4.2u, of
/// which u is its division; the scale by |v| once more, a division and a product: in all 7.2u|θ|,
/// two roots and two divisions, here 8u. A tenth covers the second order in Δ ≤ 0.05.
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
            let nearest = so3::polar(&(p * q)).map_or(Matrix3::zeros(), |(rotation, _)| rotation);
            let error = product((&p, &p_error), (&q, &q_error), 3);
            let delta = error.norm() + (p * q - nearest).norm();
            assert!(
                delta <= 0.05,
                "joint {joint} is not rigid, or its error is not small: {delta}"
            );
            let half = theta.norm() / 2.0;
            let steepness = if half > 0.0 { half / half.sin() } else { 1.0 };
            1.1 * steepness * (3f64.sqrt() * delta + 8.0 * U) + of_angle * theta.norm()
        });
    Inexact { error: error.collect(), value }
}

/// Takes, of a rotation vector that may be at π within its error, the representative that the
/// backend took: θ and θ - 2πθ/|θ| are one rotation.
pub fn same_branch(rotations: &mut Inexact<Vector3<f64>, f64>, found: &[[f32; 3]]) {
    for ((theta, error), found) in rotations.value.iter_mut().zip(&rotations.error).zip(found) {
        let other = *theta * (1.0 - 2.0 * PI / theta.norm());
        let found = Vector3::from(*found).map(f64::from);
        if theta.norm() + error >= PI && (other - found).norm() < (*theta - found).norm() {
            *theta = other;
        }
    }
}

/// Gradients, third part: `D = Q_p exp(A θ_b) [exp(A' θ_c)] S`, three products a sum: γ₃ each time.
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

/// The exponential `I + sin φ K + (1 - cos φ) K²`, φ = |ω|, K the cross product with ω/φ, of an ω
/// that is off by `omega_error`.
///
/// No entry moves by more than ω does. φ itself is off by 1.5u (a sum of squares) and a root, here
/// 2u and a root, which turns the matrix about its own axis by that times φ(|K| + |K²|). In the term
/// of K the sine is off by 2 ULP or 4u, φ below it as said, and a division and two operations
/// follow: 8u, a root and a division; in that of K² the versine likewise by 4u, φ² by 3u, and a
/// division and three operations follow: 10u and a division. Beyond π/2 the two are off by 1.3e-7
/// and 2e-7 instead, which 4u times min(φ, 1) and min(φ²/2, 2) also cover. 1 is added on the
/// diagonal: u.
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

/// Palette: `t = c1 d + c2 q`, sums of 3P + 4J products; then `B_r t`, three products and one term.
pub fn palette(
    oracle: &EnvelopeModel,
    root: &Inexact<Transform>,
    relative: &Inexact<Transform>,
    gradients: &Inexact<Matrix3<f64>>,
) -> Inexact<Transform> {
    let Some(Reconstruction { c1, c2, .. }) = &oracle.reconstruction else {
        return Inexact::exact(Vec::new());
    };
    let terms = c1.ncols() + c2.ncols();
    let unmoved = oracle.palette(&Transform::identity(), &relative.value, &gradients.value);
    let errors = stacked_error(c1, gradients, terms) + stacked_error(c2, relative, terms);
    let error = unmoved.iter().enumerate().map(|(l, transform)| {
        let error = Transform::from_fn(|r, c| errors[(4 * l + c, r)]);
        moved((&root.value[0], &root.error[0]), (transform, &error))
    });
    let value = oracle.palette(&root.value[0], &relative.value, &gradients.value);
    Inexact { error: error.collect(), value }
}

/// `|c| E + γₙ |c| (|x| + E)` of a stack x of blocks.
fn stacked_error<const C: usize>(
    coefficients: &Mat<f64>,
    blocks: &Inexact<SMatrix<f64, 3, C>>,
    terms: usize,
) -> Mat<f64> {
    let weigh = |(value, error): (&SMatrix<f64, 3, C>, &SMatrix<f64, 3, C>)| {
        value.abs() * gamma(terms) + error * (1.0 + gamma(terms))
    };
    let blocks: Vec<_> = blocks.value.iter().zip(&blocks.error).map(weigh).collect();
    magnitudes(coefficients) * stack(&blocks)
}

fn magnitudes(matrix: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |r, c| matrix[(r, c)].abs())
}

/// A transform `a` after a transform `b`.
fn moved(a: (&Transform, &Transform), b: (&Transform, &Transform)) -> Transform {
    let mut error = product((&linear(a.0), &linear(a.1)), b, 4);
    let last = (a.0.column(3).abs() + a.1.column(3)) * gamma(4) + a.1.column(3);
    error.column_mut(3).axpy(1.0, &last, 1.0);
    error
}

/// Rest to rest: matrices of zeros and ones multiply exactly, so joints, q and d are exact, and of
/// each sum only P + J terms are not 0; a correction adds 0. Coefficients and weights, exact before
/// they were rounded for the file, are off by u of themselves each. Returns the bounds of the V
/// positions.
pub fn rest(oracle: &EnvelopeModel, own: &SkinModel) -> Vec<Vector3<f64>> {
    let (p, j) = (oracle.proxy_len(), oracle.joint_len());
    let (d, q) = (vec![Matrix3::identity(); p], vec![Transform::identity(); j]);
    let palette = if let Some(Reconstruction { c1, c2, .. }) = &oracle.reconstruction {
        let sums = magnitudes(c1) * stack(&d) + magnitudes(c2) * stack(&q);
        let factor = gamma(p + j) + U;
        let error = |l: usize| Transform::from_fn(|r, c| sums[(4 * l + c, r)] * factor);
        Inexact { error: (0..p).map(error).collect(), value: vec![Transform::identity(); p] }
    } else {
        Inexact::exact(oracle.joints(&q))
    };
    let of_weights = |vertex: &Vertex<'_>| vertex.position.xyz().abs() * U;
    let position = |v: Vertex<'_>| skin(&v, &palette, Arithmetic::IEEE).position + of_weights(&v);
    own.vertices().map(position).collect()
}

/// Bounds of one skinned vertex.
#[derive(Clone, Copy, Debug)]
pub struct SkinBounds {
    /// Of the position, entry by entry.
    pub position: Vector3<f64>,
    /// Of the length of the normal's error.
    pub normal: f64,
    /// Of the length of the tangent's error; 0 without one.
    pub tangent: f64,
}

/// Skin: `M = Σ w_k T_k`, K products; `M x̂`, three products and one term; cofactors, two products
/// an entry; a direction's three products; then its length.
pub fn skin(
    vertex: &Vertex<'_>,
    palette: &Inexact<Transform>,
    arithmetic: Arithmetic,
) -> SkinBounds {
    let influences = vertex.influences.len();
    let sum = |list: &[Transform]| {
        vertex.influences.iter().map(|&(l, w)| list[l].abs() * w).sum::<Transform>()
    };
    let inherited = sum(&palette.error);
    let transform_error =
        inherited * (1.0 + gamma(influences)) + sum(&palette.value) * gamma(influences);
    let transform = vertex.blend(&palette.value);
    let (turn, turn_error) = (linear(&transform), linear(&transform_error));
    let (cofactor, cofactor_error) = (cofactors(&turn), cofactor_error(&turn, &turn_error));
    let exact = Vector3::zeros();
    let along = |matrix: (&Matrix3<f64>, &Matrix3<f64>), rest: &Vector3<f64>| {
        direction(&(matrix.0 * rest), &product(matrix, (rest, &exact), 3), arithmetic)
    };
    SkinBounds {
        position: product(
            (&transform, &transform_error),
            (&vertex.position, &nalgebra::Vector4::zeros()),
            4,
        ),
        normal: along((&cofactor, &cofactor_error), &vertex.normal),
        tangent: vertex.tangent.map_or(0.0, |(rest, _)| along((&turn, &turn_error), &rest)),
    }
}

/// Each cofactor is a difference of two products: γ₂ of their sum.
fn cofactor_error(m: &Matrix3<f64>, error: &Matrix3<f64>) -> Matrix3<f64> {
    let cross = |a: Vector3<f64>, b: Vector3<f64>| {
        Vector3::from_fn(|r, _| a[(r + 1) % 3] * b[(r + 2) % 3] + a[(r + 2) % 3] * b[(r + 1) % 3])
    };
    let columns = [0, 1, 2].map(|c| {
        let at = |c: usize| (m.column(c % 3).abs(), error.column(c % 3).into_owned());
        let ((a, ea), (b, eb)) = (at(c + 1), at(c + 2));
        cross(ea, b + eb) + cross(a, eb) + cross(a + ea, b + eb) * gamma(2)
    });
    Matrix3::from_columns(&columns)
}

/// A vector v made unit. Directions of v and v + e are at most 2|e| / (|v| + |v + e|) apart
/// (Dunkl and Williams 1964). Its squared length is off by γ₃, the length by half of that and a
/// root, and a division and a product follow: 2.5u, here 3u, a root and a division. No two unit
/// vectors are farther apart than 2: also where the squared length is no normal number, for which
/// the rest direction stands, in one of two evaluations.
fn direction(
    v: &Vector3<f64>,
    error: &Vector3<f64>,
    Arithmetic { division, root }: Arithmetic,
) -> f64 {
    let (length, error) = (v.norm(), error.norm());
    if length == 0.0 && error == 0.0 {
        return 0.0;
    }
    let apart = if error < length { error / (length - error / 2.0) } else { 2.0 };
    apart.min(2.0) + (3 + root + division) as f64 * U
}

/// `E_a |b| + |a| E_b + E_a E_b + γₙ (|a| + E_a)(|b| + E_b)` of a product behind n roundings.
pub(super) fn product<const R: usize, const K: usize, const C: usize>(
    (a, a_error): (&SMatrix<f64, R, K>, &SMatrix<f64, R, K>),
    (b, b_error): (&SMatrix<f64, K, C>, &SMatrix<f64, K, C>),
    roundings: usize,
) -> SMatrix<f64, R, C> {
    let (a, b) = (a.abs(), b.abs());
    let (a_most, b_most) = (a + a_error, b + b_error);
    a_error * b_most + a * b_error + a_most * b_most * gamma(roundings)
}
