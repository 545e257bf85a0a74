//! Affine maps as 3x4 matrices `[L | t]`: `y = L x + t`; distances between point sets, and tangents of normals.

use nalgebra::{Matrix3, Matrix3x4, Vector3, Vector4};

/// Returns `[x 1]`.
pub fn homogeneous(x: &[f64; 3]) -> Vector4<f64> {
    Vector4::new(x[0], x[1], x[2], 1.0)
}

/// Returns the linear part of a map.
pub fn linear(map: &Matrix3x4<f64>) -> Matrix3<f64> {
    map.fixed_columns::<3>(0).into_owned()
}

/// Joins a linear part and an offset into a map.
pub fn joined(linear: &Matrix3<f64>, offset: &Vector3<f64>) -> Matrix3x4<f64> {
    Matrix3x4::from_fn(|row, column| if column < 3 { linear[(row, column)] } else { offset[row] })
}

/// Makes a map from three rows.
pub fn from_rows(rows: &[[f64; 4]; 3]) -> Matrix3x4<f64> {
    Matrix3x4::from_fn(|r, c| rows[r][c])
}

/// Splits a map of three rows into its linear part and its offset.
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

/// Strain of a linear part L, (LᵀL - I) / 2: xx, xy, xz, yy, yz, zz.
pub type Strain = [f64; 6];

/// Returns the strain of a linear part; 0 for a rotation.
pub fn strain(linear: &Matrix3<f64>) -> Strain {
    let strain = (linear.transpose() * linear - Matrix3::identity()) * 0.5;
    [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|at| strain[at])
}

/// Returns the Frobenius norm of a strain. Entries off the diagonal count twice.
pub fn strain_norm([xx, xy, xz, yy, yz, zz]: &Strain) -> f64 {
    (xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz)).sqrt()
}

/// Returns `a⁻¹ b` for a rigid `a`: b in the frame of a.
pub fn seen_from(a: &Matrix3x4<f64>, b: &Matrix3x4<f64>) -> Matrix3x4<f64> {
    let mut apart = *b;
    apart.column_mut(3).axpy(-1.0, &a.column(3), 1.0);
    linear(a).transpose() * apart
}

/// Returns the cofactors of a linear part, `det(m) m⁻ᵀ`, which transform normals.
///
/// Such normals point outward even where a blend shrinks or flattens the surface.
pub fn cofactors(m: &Matrix3<f64>) -> Matrix3<f64> {
    let [a, b, c] = [0, 1, 2].map(|k| m.column(k).into_owned());
    Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)])
}

/// Returns the RMS distance between corresponding points.
pub fn apart<const N: usize>(a: &[[f64; N]], b: &[[f64; N]]) -> f64 {
    let squared = |(a, b): (&[f64; N], &[f64; N])| -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum()
    };
    (a.iter().zip(b).map(squared).sum::<f64>() / a.len().max(1) as f64).sqrt()
}

/// Returns an RMS distance between two point sets that ignores their order; 0 for equal sets.
///
/// Compares the coordinates of each axis and the distances from the origin, all sorted.
pub fn apart_unordered(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    apart(&unordered(a), &unordered(b))
}

/// Returns t of the right-handed frame (t, b = n x t, n) of a unit normal n, without a branch (T. Duff et al.,
/// *Building an orthonormal basis, revisited*, JCGT 6, 2017).
pub fn tangent(n: &Vector3<f64>) -> Vector3<f64> {
    let sign = 1.0_f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    Vector3::new(1.0 + sign * n.x * n.x * a, sign * n.x * n.y * a, -sign * n.x)
}

fn unordered(points: &[[f64; 3]]) -> Vec<[f64; 4]> {
    let mut all = vec![[0.0; 4]; points.len()];
    for k in 0..4 {
        let of =
            |x: &[f64; 3]| if k < 3 { x[k] } else { x.iter().map(|x| x * x).sum::<f64>().sqrt() };
        let mut values: Vec<f64> = points.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        all.iter_mut().zip(values).for_each(|(all, value)| all[k] = value);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn a_tangent_has_length_1_and_is_orthogonal_to_its_normal() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(2);
        let any = |_| Vector3::from_fn(|_, _| random.random_range(-1.0..1.0)).normalize();
        let poles = [Vector3::z(), -Vector3::z(), Vector3::x(), -Vector3::y()];
        for n in poles.into_iter().chain((0..1000).map(any)) {
            let t = tangent(&n);
            assert!((t.norm() - 1.0).abs() < 1e-12 && t.dot(&n).abs() < 1e-12, "{n} {t}");
        }
        // The frame jumps at the equator only: the sign of 0 matters.
        assert_eq!(tangent(&Vector3::x()), -Vector3::z());
        assert_eq!(tangent(&Vector3::new(1.0, 0.0, -0.0)), Vector3::z());
    }
}
