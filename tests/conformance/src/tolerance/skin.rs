//! The tolerance of stage skin; and of the rest pose, which is exact except for the file's
//! rounding.

use super::directions::{Direction, directions};
use super::inexact::{Inexact, Transform, magnitudes, product};
use nalgebra::{Matrix3, Vector3};
use sinew_runtime::Skin;
use sinew_trainer::envelope::model::{EnvelopeModel, Reconstruction, SkinModel, Vertex};
use sinew_trainer::envelope::oracle::stack;
use sinew_trainer::regression::arithmetic::{Arithmetic, U, gamma};

/// A skinned vertex with its bounds.
#[derive(Clone, Copy, Debug)]
pub struct Skinned {
    /// The oracle's position.
    pub position: Vector3<f64>,
    /// Bounds of the position, entry by entry.
    pub position_error: Vector3<f64>,
    /// The normal.
    pub normal: Direction,
    /// The tangent and its handedness.
    pub tangent: Option<(Direction, f64)>,
}

/// Bounds a skinned vertex: `M = Σ w_k T_k`, K products; `M x̂`, three products and one term; then
/// the directions.
///
/// - `number`: index of the vertex in the skin.
pub fn skin(
    (skin, number): (&Skin<'_>, usize),
    vertex: &Vertex<'_>,
    palette: &Inexact<Transform>,
    arithmetic: Arithmetic,
) -> Skinned {
    let (transform, error) = blended(vertex, palette);
    let (normal, tangent) =
        directions((skin, number), vertex, palette, (&transform, &error), arithmetic);
    Skinned {
        position: transform * vertex.position,
        position_error: position_error(vertex, (&transform, &error)),
        normal,
        tangent: tangent.zip(vertex.tangent.map(|(_, hand)| hand)),
    }
}

/// Returns the blended transform M and the bounds of its entries.
fn blended(vertex: &Vertex<'_>, palette: &Inexact<Transform>) -> (Transform, Transform) {
    let influences = vertex.influences.len();
    let sum = |list: &[Transform]| {
        vertex.influences.iter().map(|&(l, w)| list[l].abs() * w).sum::<Transform>()
    };
    let inherited = sum(&palette.error);
    let error = inherited * (1.0 + gamma(influences)) + sum(&palette.value) * gamma(influences);
    (vertex.blend(&palette.value), error)
}

fn position_error(vertex: &Vertex<'_>, transform: (&Transform, &Transform)) -> Vector3<f64> {
    product(transform, (&vertex.position, &nalgebra::Vector4::zeros()), 4)
}

/// Bounds the V positions of the rest pose.
///
/// Matrices of zeros and ones multiply exactly, so joints, q and d are exact. Each sum has only P +
/// J terms that are not 0, and a correction adds 0. Coefficients and weights were exact before they
/// were rounded for the file, so each has a relative error of u.
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
    let position = |v: Vertex<'_>| {
        let (transform, error) = blended(&v, &palette);
        position_error(&v, (&transform, &error)) + of_weights(&v)
    };
    own.vertices().map(position).collect()
}
