//! Affine maps as bones hold them: translation, rotation and scale along the axes of the rest pose (METHOD §1.13).

use super::affine::{joined, linear};
use super::so3::polar;
use nalgebra::{Matrix3, Matrix3x4, Matrix4, Vector3};
use sinew_runtime::envelope::HelperKind;

/// Least and greatest sum of the squares of a linear part that is projected (FORMAT.md).
const SQUARES: [f64; 2] = [1e-6, 1e6];
/// Least determinant of a projected linear part of the norm of a rotation (FORMAT.md).
const FLAT: f64 = 0.1;

/// Added to the diagonal of a file's spread, so that the runtime's steps reach its rotations. A hundredth or a tenth
/// changes the error of bones by 3 % at most.
pub const FLAT_SPREAD: f64 = 0.03;

/// Where the vertices of a helper are at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Mean of the vertices, by squared weights.
    pub centre: Vector3<f64>,
    /// Covariance of the vertices, by squared weights, in any unit; its diagonal is positive.
    pub spread: Matrix3<f64>,
}

impl Place {
    /// Makes the place of vertices that spread evenly about a centre.
    pub fn at(centre: [f64; 3]) -> Self {
        Self { centre: centre.into(), spread: Matrix3::identity() }
    }

    /// Makes the place from G, the sum of `h hᵀ` over the vertices, h = [w x, w]. The spread has the trace 1 and `flat`
    /// more on its diagonal; a sum without a vertex gives `None`.
    pub fn new(gram: &Matrix4<f64>, flat: f64) -> Option<Self> {
        let weight = gram[(3, 3)];
        if weight <= 0.0 {
            return None;
        }
        let centre: Vector3<f64> = gram.fixed_view::<3, 1>(0, 3) / weight;
        let squares = gram.fixed_view::<3, 3>(0, 0) / weight;
        let spread = squares - centre * centre.transpose();
        let trace = spread.trace();
        // Vertices at one place leave only rounding.
        let has_spread = trace > 1e-12 * squares.trace();
        let spread = if has_spread { spread / trace } else { Matrix3::identity() / 3.0 };
        Some(Self { centre, spread: spread + Matrix3::identity() * flat })
    }
}

/// Projects a map onto a kind: the nearest rotation R of its linear part L, and the scale along the axes at rest, the
/// diagonal of RᵀL. The image of the centre stays. A map that is nearly 0, huge or flat stays too.
pub fn project(kind: HelperKind, map: &Matrix3x4<f64>, centre: &Vector3<f64>) -> Matrix3x4<f64> {
    let place = Place::at((*centre).into());
    match kind {
        HelperKind::Affine => *map,
        _ if !is_upright(&linear(map)) => *map,
        _ => nearest(kind, map, &Vector3::repeat(1.0), &place),
    }
}

/// Returns the transform of a bone nearest to a map, measured on the vertices at its place. A map that is nearly 0, huge
/// or flat gets the identity as its rotation.
pub fn bone(map: &Matrix3x4<f64>, place: &Place) -> Matrix3x4<f64> {
    if is_upright(&linear(map)) {
        return nearest(HelperKind::Trs, map, &Vector3::repeat(1.0), place);
    }
    with_scale(HelperKind::Trs, &Matrix3::identity(), map, place)
}

/// Returns a map of a kind near to a map, measured on the vertices at a place: the best rotation for given scale, then
/// the best scale. The image of the centre stays.
///
/// A map that mirrors gives a rotation with three negative scales.
pub fn nearest(
    kind: HelperKind,
    map: &Matrix3x4<f64>,
    scale: &Vector3<f64>,
    place: &Place,
) -> Matrix3x4<f64> {
    let own = linear(map);
    let mirror = if own.determinant() < 0.0 { -1.0 } else { 1.0 };
    let weighed = own * place.spread * Matrix3::from_diagonal(scale) * mirror;
    let turn = polar(&weighed).map_or(Matrix3::identity(), |(turn, _)| turn);
    with_scale(kind, &(turn * mirror), map, place)
}

/// Joins a rotation R with the scale of RᵀL, so that the centre goes to its image.
fn with_scale(
    kind: HelperKind,
    turn: &Matrix3<f64>,
    map: &Matrix3x4<f64>,
    Place { centre, spread }: &Place,
) -> Matrix3x4<f64> {
    let along = (turn.transpose() * linear(map) * spread).diagonal();
    let scale = match kind {
        HelperKind::Rigid => Vector3::repeat(1.0),
        _ => along.component_div(&spread.diagonal()),
    };
    let scaled = turn * Matrix3::from_diagonal(&scale);
    joined(&scaled, &(map * centre.push(1.0) - scaled * centre))
}

/// Whether a linear part is neither nearly 0, nor huge, nor flat.
fn is_upright(own: &Matrix3<f64>) -> bool {
    let square = own.norm_squared();
    let [least, most] = SQUARES;
    let volume = own.determinant() * (3.0 / square).powf(1.5);
    square > least && square < most && volume.abs() > FLAT
}
