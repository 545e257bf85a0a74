//! The moving surface: coordinates on its trajectory basis, and deformation gradients of its triangles (METHOD §1.3, S3
//! §1). Proxies and keys are fitted to these coordinates.

use crate::examples::Importance;
use crate::numeric::basis::Basis;
use crate::numeric::columns;
use faer::Mat;
use nalgebra::{Matrix3, Vector3};
use std::collections::{BTreeMap, BTreeSet};

/// A rest mesh, and the trajectories of its vertices and normals in coordinates on a basis.
pub struct Surface<'a> {
    /// n, number of frames in the trajectories.
    pub frames: usize,
    /// V rest positions.
    pub rest: &'a [[f64; 3]],
    /// T triangles, each with a positive area.
    pub triangles: Vec<[usize; 3]>,
    /// Coordinates of the vertices' trajectories, r x V.
    pub vertices: &'a Mat<f64>,
    /// n̂ of each triangle, T; about as long as an edge.
    pub rest_normals: Vec<Vector3<f64>>,
    /// Coordinates of the normals' trajectories, projected onto the basis, r x T.
    pub normals: Mat<f64>,
    /// Weight of each vertex in the fits.
    pub importance: Importance<'a>,
}

impl<'a> Surface<'a> {
    /// Projects the trajectories of a mesh onto their basis.
    ///
    /// - `trajectories`: 3n x V.
    pub fn new(
        rest: &'a [[f64; 3]],
        triangles: Vec<[usize; 3]>,
        trajectories: &Mat<f64>,
        basis: &'a Basis,
        importance: Importance<'a>,
    ) -> Self {
        let rest_normals: Vec<_> =
            triangles.iter().map(|t| edge_frame(t.map(|v| &rest[v])).column(2).into()).collect();
        let mut normals = Mat::zeros(basis.vectors.ncols(), triangles.len());
        columns::fill(&mut normals, |triangle, out| {
            let posed = posed_normals(triangles[triangle].map(|v| trajectories.col_as_slice(v)));
            for (value, direction) in out.iter_mut().zip(basis.vectors.col_iter()) {
                *value = direction.transpose() * &posed;
            }
        });
        Self {
            frames: trajectories.nrows() / 3,
            rest,
            triangles,
            vertices: &basis.coordinates,
            rest_normals,
            normals,
            importance,
        }
    }

    /// Returns the weight of a triangle: the mean weight of its corners.
    pub fn triangle_importance(&self, triangle: usize) -> f64 {
        self.triangles[triangle].map(|vertex| self.importance.of(vertex)).iter().sum::<f64>() / 3.0
    }

    /// Returns the triangles that share an edge with each triangle.
    pub fn neighbours(&self) -> Vec<BTreeSet<u32>> {
        let mut of_edge = BTreeMap::<(usize, usize), Vec<u32>>::new();
        for (triangle, &[a, b, c]) in self.triangles.iter().enumerate() {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                of_edge.entry((p.min(q), p.max(q))).or_default().push(triangle as u32);
            }
        }
        let mut neighbours = vec![BTreeSet::new(); self.triangles.len()];
        for sharing in of_edge.values() {
            for &a in sharing {
                neighbours[a as usize].extend(sharing.iter().copied().filter(|&b| b != a));
            }
        }
        neighbours
    }
}

/// Returns the frame `[e1 e2 n]` of a triangle: n = (e1 x e2)/√|e1 x e2|, or 0 if the triangle has no area.
pub fn edge_frame(corners: [&[f64; 3]; 3]) -> Matrix3<f64> {
    let [a, b, c] = corners.map(|p| Vector3::from(*p));
    let (e1, e2) = (b - a, c - a);
    let cross = e1.cross(&e2);
    let length = cross.norm();
    let normal = if length > 0.0 { cross / length.sqrt() } else { Vector3::zeros() };
    Matrix3::from_columns(&[e1, e2, normal])
}

/// Returns the deformation gradient from a rest triangle to a posed triangle; `None` if the rest triangle has no area.
pub fn gradient(rest: [&[f64; 3]; 3], posed: [&[f64; 3]; 3]) -> Option<Matrix3<f64>> {
    edge_frame(rest).try_inverse().map(|inverse| edge_frame(posed) * inverse)
}

/// Returns the normals of a triangle in n frames, 3n, from the trajectories of its corners.
fn posed_normals(corners: [&[f64]; 3]) -> faer::Col<f64> {
    let mut all = faer::Col::zeros(corners[0].len());
    for frame in 0..corners[0].len() / 3 {
        let [a, b, c] = corners.map(|y| [y[3 * frame], y[3 * frame + 1], y[3 * frame + 2]]);
        let normal = edge_frame([&a, &b, &c]).column(2).into_owned();
        for axis in 0..3 {
            all[3 * frame + axis] = normal[axis];
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::so3;

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
    fn a_flat_rest_triangle_has_no_gradient() {
        let flat = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        assert!(gradient(flat.each_ref(), REST.each_ref()).is_none());
    }
}
