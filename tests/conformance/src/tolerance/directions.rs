//! Normals and tangents in f64, as FORMAT.md defines them under "Skin", and the tolerance of each.

use super::inexact::{Inexact, Transform, product};
use nalgebra::{Matrix3, Vector3};
use sinew_runtime::Skin;
use sinew_trainer::envelope::model::Vertex;
use sinew_trainer::numeric::affine::{cofactors, linear};
use sinew_trainer::regression::arithmetic::{Arithmetic, U, gamma};

/// A direction of length 1, or 0.
#[derive(Clone, Copy, Debug)]
pub struct Direction {
    /// The oracle's direction.
    pub value: Vector3<f64>,
    /// Bound of the length of the error.
    pub error: f64,
}

/// Largest distance of two directions.
const ANY: f64 = 2.0;

/// Returns a vertex's normal and tangent.
///
/// - `(transform, transform_error)`: the blended transform M, and the bounds of its entries.
pub(super) fn directions(
    (skin, number): (&Skin<'_>, usize),
    vertex: &Vertex<'_>,
    palette: &Inexact<Transform>,
    (transform, transform_error): (&Transform, &Transform),
    arithmetic: Arithmetic,
) -> (Direction, Option<Direction>) {
    let (turn, turn_error) = (linear(transform), linear(transform_error));
    let side = side(palette);
    let tangent = vertex.tangent.map(|(tangent, _)| tangent);
    if !skin.has_coefficients() {
        let (cofactor, cofactor_error) = (cofactors(&turn), cofactor_error(&turn, &turn_error));
        let normal = transformed((&cofactor, &cofactor_error), &Bounded::exact(vertex.normal));
        let tangent = tangent.map(|rest| {
            transformed((&turn, &turn_error), &Bounded::exact(rest)).direction(rest, arithmetic)
        });
        return (oriented(normal.direction(vertex.normal, arithmetic), &normal, side), tangent);
    }
    let [u, v] = frame(vertex.normal, tangent, arithmetic);
    let [g, h] = coefficient_terms((skin, number), vertex, palette);
    let image = |along: &Bounded| transformed((&turn, &turn_error), along);
    let normal = image(&u).plus(&g).cross(&image(&v).plus(&h));
    let tangent = tangent.map(|rest| {
        let part = |of: &Bounded, along: &Bounded| of.times(along.dot(&rest));
        let turned = image(&Bounded::exact(rest)).plus(&part(&g, &u)).plus(&part(&h, &v));
        turned.direction(rest, arithmetic)
    });
    if normal.value.norm_squared() >= f64::from(f32::MIN_POSITIVE) {
        return (oriented(normal.direction(vertex.normal, arithmetic), &normal, side), tangent);
    }
    // The first of equal influences.
    let stronger = |a: (usize, f64), b: (usize, f64)| if b.1 > a.1 { b } else { a };
    let strongest = vertex.influences.iter().copied().reduce(stronger).map_or(0, |(l, _)| l);
    let (own, own_error) = (linear(&palette.value[strongest]), linear(&palette.error[strongest]));
    let turned = transformed((&own, &own_error), &Bounded::exact(vertex.normal));
    let mut found = turned.direction(vertex.normal, arithmetic);
    if normal.value != Vector3::zeros() || normal.error != Vector3::zeros() {
        found.error = ANY;
    }
    (found, tangent)
}

/// Orients a direction by the palette's side, unless it is the rest direction. If the side is
/// uncertain, any direction is accepted.
fn oriented(found: Direction, of: &Bounded, side: Option<f64>) -> Direction {
    let Direction { value, error } = found;
    match side {
        Some(side) if of.value != Vector3::zeros() => Direction { value: value * side, error },
        None if of.value != Vector3::zeros() => Direction { value, error: ANY },
        _ => found,
    }
}

/// Returns -1 if the palette mirrors, else 1; `None` if rounding may decide. The determinant has
/// five products and sums in a row; the permanent has the same terms, all positive.
fn side(palette: &Inexact<Transform>) -> Option<f64> {
    let (value, error) = (linear(palette.value.first()?), linear(palette.error.first()?));
    let permanent = |m: &Matrix3<f64>| {
        let of = |r: usize, c: usize| m[(r, c % 3)];
        (0..3)
            .map(|c| of(0, c) * (of(1, c + 1) * of(2, c + 2) + of(1, c + 2) * of(2, c + 1)))
            .sum::<f64>()
    };
    let (least, most) = (permanent(&value.abs()), permanent(&(value.abs() + error)));
    let (volume, error) = (value.determinant(), most - least + most * gamma(5));
    (volume.abs() > error || most == 0.0).then_some(if volume < 0.0 { -1.0 } else { 1.0 })
}

/// Returns the frame's two directions: u, v.
pub(super) fn frame(
    normal: Vector3<f64>,
    tangent: Option<Vector3<f64>>,
    Arithmetic { division, .. }: Arithmetic,
) -> [Bounded; 2] {
    let n = Bounded::exact(normal);
    if let Some(tangent) = tangent {
        let v = n.cross(&Bounded::exact(tangent));
        return [v.cross(&n), v];
    }
    let [x, y, z]: [f64; 3] = normal.into();
    let side = 1.0f64.copysign(z);
    let share = x / (side + z);
    // A sum and a division; then a product, and for the first entry a difference.
    let share_error = share.abs() * gamma(1 + division);
    let of = |by: f64| by.abs() * (share_error + (share.abs() + share_error) * gamma(1));
    let value = Vector3::new(1.0 - side * x * share, -(side * y * share), -side * x);
    let error = Vector3::new(of(x) * (1.0 + U) + value.x.abs() * U, of(y), 0.0);
    let u = Bounded { value, error };
    [u, n.cross(&u)]
}

/// Returns the correction of the frame by tangent coefficients: sums of g (y - y_first) and of h (y
/// - y_first).
fn coefficient_terms(
    (skin, number): (&Skin<'_>, usize),
    vertex: &Vertex<'_>,
    palette: &Inexact<Transform>,
) -> [Bounded; 2] {
    let place = |l: usize| Bounded {
        value: palette.value[l] * vertex.position,
        error: product(
            (&palette.value[l], &palette.error[l]),
            (&vertex.position, &nalgebra::Vector4::zeros()),
            4,
        ),
    };
    let Some((first, others)) = vertex.influences.split_first() else {
        return [Bounded::exact(Vector3::zeros()); 2];
    };
    let first = place(first.0).negated();
    let apart: Vec<_> = others.iter().map(|&(l, _)| place(l).plus(&first)).collect();
    let sum = |which: usize| {
        let coefficients = skin.tangent_coefficients(number).map(|pair| f64::from(pair[which]));
        let terms: Vec<_> =
            apart.iter().zip(coefficients).map(|(apart, by)| apart.times((by, 0.0))).collect();
        let most = terms.iter().map(|term| term.value.abs() + term.error).sum::<Vector3<f64>>();
        let error = terms.iter().map(|term| term.error).sum::<Vector3<f64>>();
        Bounded {
            value: terms.iter().map(|term| term.value).sum(),
            error: error + most * gamma(terms.len()),
        }
    };
    [sum(0), sum(1)]
}

/// A vector with bounds of its entries.
#[derive(Clone, Copy)]
pub(super) struct Bounded {
    pub(super) value: Vector3<f64>,
    pub(super) error: Vector3<f64>,
}

impl Bounded {
    pub(super) fn exact(value: Vector3<f64>) -> Self {
        Self { value, error: Vector3::zeros() }
    }

    fn negated(&self) -> Self {
        Self { value: -self.value, error: self.error }
    }

    fn most(&self) -> Vector3<f64> {
        self.value.abs() + self.error
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        let (value, error) = (self.value + other.value, self.error + other.error);
        Self { value, error: error + (value.abs() + error) * U }
    }

    /// Multiplies by a number: one product an entry.
    pub(super) fn times(&self, (by, by_error): (f64, f64)) -> Self {
        let inherited = self.value.abs() * by_error + self.error * (by.abs() + by_error);
        let error = inherited + self.most() * ((by.abs() + by_error) * U);
        Self { value: self.value * by, error }
    }

    /// Returns the dot product: three products and their sum.
    fn dot(&self, other: &Vector3<f64>) -> (f64, f64) {
        let most = self.most().dot(&other.abs());
        (self.value.dot(other), self.error.dot(&other.abs()) + most * gamma(3))
    }

    /// Returns the cross product. Each entry is a difference of two products: γ₂ of their sum.
    fn cross(&self, other: &Self) -> Self {
        let error = positive_cross(self.error, other.most())
            + positive_cross(self.value.abs(), other.error)
            + positive_cross(self.most(), other.most()) * gamma(2);
        Self { value: self.value.cross(&other.value), error }
    }

    /// Returns the direction of the vector; `rest` if the vector is 0.
    ///
    /// The directions of v and v + e differ by at most 2|e| / (|v| + |v + e|) (Dunkl and Williams
    /// 1964). The squared length has an error of γ₃, the length half of that and a root. A division
    /// and a product follow. In total 2.5u, here 3u, plus a root and a division. Two unit vectors
    /// differ by at most 2. That also bounds the case in which the squared length is not a normal
    /// number, and only one of two evaluations returns the rest direction.
    pub(super) fn direction(
        &self,
        rest: Vector3<f64>,
        Arithmetic { division, root }: Arithmetic,
    ) -> Direction {
        let value = self.value.try_normalize(0.0).unwrap_or(rest);
        let (length, error) = (self.value.norm(), self.error.norm());
        if length == 0.0 && error == 0.0 {
            return Direction { value, error: 0.0 };
        }
        let apart = if error < length { error / (length - error / 2.0) } else { ANY };
        Direction { value, error: apart.min(ANY) + (3 + root + division) as f64 * U }
    }
}

/// Returns a matrix times a vector: three products an entry.
fn transformed(matrix: (&Matrix3<f64>, &Matrix3<f64>), v: &Bounded) -> Bounded {
    Bounded { value: matrix.0 * v.value, error: product(matrix, (&v.value, &v.error), 3) }
}

/// Returns the bounds of the cofactors. Each cofactor is a difference of two products: γ₂ of their
/// sum.
pub(super) fn cofactor_error(m: &Matrix3<f64>, error: &Matrix3<f64>) -> Matrix3<f64> {
    let columns = [0, 1, 2].map(|c| {
        let at = |c: usize| Bounded {
            value: m.column(c % 3).into_owned(),
            error: error.column(c % 3).into_owned(),
        };
        at(c + 1).cross(&at(c + 2)).error
    });
    Matrix3::from_columns(&columns)
}

/// Returns the cross product with all terms added.
fn positive_cross(a: Vector3<f64>, b: Vector3<f64>) -> Vector3<f64> {
    Vector3::from_fn(|r, _| a[(r + 1) % 3] * b[(r + 2) % 3] + a[(r + 2) % 3] * b[(r + 1) % 3])
}
