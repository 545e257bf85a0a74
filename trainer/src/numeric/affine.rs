//! Affine maps as 3x4 matrices `[L | t]`: `y = L x + t`.

use nalgebra::{Matrix3, Matrix3x4, Vector3, Vector4};

/// Returns `[x 1]`.
pub fn homogeneous(x: &[f64; 3]) -> Vector4<f64> {
    Vector4::new(x[0], x[1], x[2], 1.0)
}

/// Returns the linear part of a map.
pub fn linear(map: &Matrix3x4<f64>) -> Matrix3<f64> {
    map.fixed_columns::<3>(0).into_owned()
}

/// Puts a map together of its linear part and its offset.
pub fn joined(linear: &Matrix3<f64>, offset: &Vector3<f64>) -> Matrix3x4<f64> {
    Matrix3x4::from_columns(&[
        linear.column(0),
        linear.column(1),
        linear.column(2),
        offset.column(0),
    ])
}

/// Reads a map of three rows.
pub fn from_rows(rows: &[[f64; 4]; 3]) -> Matrix3x4<f64> {
    Matrix3x4::from_fn(|r, c| rows[r][c])
}

/// Takes a map of three rows apart: its linear part and its offset.
pub fn parts(rows: &[[f64; 4]; 3]) -> (Matrix3<f64>, Vector3<f64>) {
    let map = from_rows(rows);
    (linear(&map), map.column(3).into_owned())
}

/// Writes a map as three rows.
pub fn to_rows(map: &Matrix3x4<f64>) -> [[f64; 4]; 3] {
    [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| map[(r, c)]))
}

/// Composes two maps: `a` after `b`.
pub fn after(a: &Matrix3x4<f64>, b: &Matrix3x4<f64>) -> Matrix3x4<f64> {
    let mut out = linear(a) * b;
    let moved = out.column(3) + a.column(3);
    out.set_column(3, &moved);
    out
}

/// Returns `a⁻¹ b`, a taken as rigid: b as one sees it who moves with a.
pub fn seen_from(a: &Matrix3x4<f64>, b: &Matrix3x4<f64>) -> Matrix3x4<f64> {
    let mut apart = *b;
    apart.column_mut(3).axpy(-1.0, &a.column(3), 1.0);
    linear(a).transpose() * apart
}

/// Returns the cofactors of a linear part, `det(m) m⁻ᵀ`, which move normals: they point outward also
/// where a blend shrinks or flattens.
pub fn cofactors(m: &Matrix3<f64>) -> Matrix3<f64> {
    let [a, b, c] = [0, 1, 2].map(|k| m.column(k).into_owned());
    Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)])
}
