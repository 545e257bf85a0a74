//! Deformation gradients of triangles and their polar decomposition (METHOD §1.3, S3 §1).

use crate::numeric::so3;
use nalgebra::{Matrix3, Vector3};

/// The frame `[e1 e2 n]` of a triangle, n = (e1 x e2)/√|e1 x e2|, zero where the cross product is.
pub fn edge_frame(corners: [&[f64; 3]; 3]) -> Matrix3<f64> {
    let [a, b, c] = corners.map(|p| Vector3::from(*p));
    frame_of_edges(&(b - a), &(c - a))
}

/// The frame `[e1 e2 n]` of two edges.
pub fn frame_of_edges(e1: &Vector3<f64>, e2: &Vector3<f64>) -> Matrix3<f64> {
    let cross = e1.cross(e2);
    let length = cross.norm();
    let normal = if length > 0.0 { cross / length.sqrt() } else { Vector3::zeros() };
    Matrix3::from_columns(&[*e1, *e2, normal])
}

/// Returns the deformation gradient from a rest triangle to a posed one; `None` where the rest
/// triangle has no area.
pub fn gradient(rest: [&[f64; 3]; 3], posed: [&[f64; 3]; 3]) -> Option<Matrix3<f64>> {
    edge_frame(rest).try_inverse().map(|inverse| edge_frame(posed) * inverse)
}

/// Splits a sequence of gradients into rotations and stretches.
///
/// A gradient of rank one or less takes the rotation of the nearest frame that has one (the
/// identity where none has), and its stretch is `Rᵀ D`, symmetrised.
pub fn polar_sequence(gradients: &[Matrix3<f64>]) -> Vec<(Matrix3<f64>, Matrix3<f64>)> {
    let split: Vec<_> = gradients.iter().map(so3::polar).collect();
    (0..gradients.len())
        .map(|i| {
            split[i].unwrap_or_else(|| {
                let nearest = (1..split.len())
                    .flat_map(|step| [i.checked_sub(step), Some(i + step)])
                    .flatten()
                    .find_map(|k| split.get(k).copied().flatten());
                let rotation = nearest.map_or(Matrix3::identity(), |(rotation, _)| rotation);
                let stretch = rotation.transpose() * gradients[i];
                (rotation, (stretch + stretch.transpose()) * 0.5)
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const REST: [[f64; 3]; 3] = [[0.1, 0.0, 0.0], [1.0, 0.2, 0.0], [0.0, 1.0, 0.3]];

    fn moved(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
        REST.map(|p| (m * Vector3::from(p) + Vector3::new(5.0, -2.0, 1.0)).into())
    }

    #[test]
    fn a_similarity_is_its_own_gradient() {
        let m = so3::exp(&Vector3::new(0.4, -1.0, 2.0)) * 1.7;
        let d = gradient(REST.each_ref(), moved(&m).each_ref()).unwrap();
        assert!((d - m).amax() < 1e-12);
    }

    #[test]
    fn an_affine_map_is_found_on_the_edges() {
        let m = Matrix3::new(1.0, 0.3, 0.0, -0.2, 0.8, 0.1, 0.0, 0.5, 1.4);
        let d = gradient(REST.each_ref(), moved(&m).each_ref()).unwrap();
        for corner in &REST[1..] {
            let edge = Vector3::from(*corner) - Vector3::from(REST[0]);
            assert!((d * edge - m * edge).norm() < 1e-12);
        }
    }

    #[test]
    fn a_flat_rest_triangle_has_none_and_a_collapsed_pose_borrows_a_rotation() {
        let flat = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        assert!(gradient(flat.each_ref(), REST.each_ref()).is_none());
        let turned = so3::exp(&Vector3::new(0.0, 0.0, 1.0));
        let split = polar_sequence(&[turned, Matrix3::zeros()]);
        assert!((split[1].0 - turned).amax() < 1e-12 && split[1].1.amax() == 0.0);
    }
}
