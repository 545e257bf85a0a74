//! The tolerance of stage skin: positions, normals, tangents; and of the rest pose, which is exact but
//! for the file's rounding.

use super::inexact::{Inexact, Transform, magnitudes, product};
use nalgebra::{Matrix3, Vector3};
use sinew_trainer::envelope::model::{EnvelopeModel, Reconstruction, SkinModel, Vertex};
use sinew_trainer::envelope::oracle::stack;
use sinew_trainer::kernel::arithmetic::{Arithmetic, U, gamma};
use sinew_trainer::numeric::affine::{cofactors, linear};

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
