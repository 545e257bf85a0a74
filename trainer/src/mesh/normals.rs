//! Normals of a mesh by the area of its triangles.

use nalgebra::Vector3;

/// Unit normals this near are one: files round them.
pub const SAME_NORMAL: f64 = 1e-3;

/// Tells whether two unit normals are one but for rounding.
pub fn same_normal(a: &[f64; 3], b: &[f64; 3]) -> bool {
    (Vector3::from(*a) - Vector3::from(*b)).norm() <= SAME_NORMAL
}

/// Computes a mesh's unit normals, weighted by triangle area; zero where there is no area.
pub(crate) fn normals(positions: &[[f64; 3]], triangles: &[[usize; 3]]) -> Vec<[f64; 3]> {
    let mut normals = vec![Vector3::zeros(); positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| Vector3::from(positions[vertex]));
        let twice_area = (b - a).cross(&(c - a));
        for &vertex in triangle {
            normals[vertex] += twice_area;
        }
    }
    normals.iter().map(|normal| normal.try_normalize(0.0).unwrap_or_default().into()).collect()
}
