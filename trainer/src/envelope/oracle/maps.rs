//! Maps, as the oracle needs them.

use nalgebra::{Matrix3, Matrix3x4, Matrix4, Vector4, Vector6};

/// Returns the linear part of a map.
pub fn linear(map: &Matrix3x4<f64>) -> Matrix3<f64> {
    map.fixed_columns::<3>(0).into_owned()
}

/// Returns `a⁻¹ b`, a taken as rigid: b as one sees it who moves with a.
pub fn seen_from(a: &Matrix3x4<f64>, b: &Matrix3x4<f64>) -> Matrix3x4<f64> {
    let mut apart = *b;
    apart.column_mut(3).axpy(-1.0, &a.column(3), 1.0);
    linear(a).transpose() * apart
}

/// Composes two maps: `a` after `b`.
pub fn after(a: &Matrix3x4<f64>, b: &Matrix3x4<f64>) -> Matrix3x4<f64> {
    let square = b.insert_row(3, 0.0) + Matrix4::from_diagonal(&Vector4::w());
    a * square
}

/// Returns `[xx xy xz; xy yy yz; xz yz zz]`.
pub fn symmetric(s: &Vector6<f64>) -> Matrix3<f64> {
    let [xx, xy, xz, yy, yz, zz] = (*s).into();
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// Returns the cofactors of a matrix, which move normals: `det(m) m⁻ᵀ`.
pub fn cofactors(m: &Matrix3<f64>) -> Matrix3<f64> {
    let minor = |r: usize, c: usize| m.remove_row(r).remove_column(c).determinant();
    Matrix3::from_fn(|r, c| if (r + c) % 2 == 0 { minor(r, c) } else { -minor(r, c) })
}

/// Stacks transposed blocks: row C l + c, column r is entry r, c of block l.
pub fn stack<const C: usize>(
    blocks: &[nalgebra::SMatrix<f64, 3, C>],
) -> nalgebra::OMatrix<f64, nalgebra::Dyn, nalgebra::U3> {
    nalgebra::OMatrix::<f64, nalgebra::Dyn, nalgebra::U3>::from_fn(C * blocks.len(), |row, r| {
        blocks[row / C][(r, row % C)]
    })
}
