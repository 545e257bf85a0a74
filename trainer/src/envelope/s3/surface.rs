//! The moving surface in coordinates on its trajectory basis: what proxies and keys are fitted to.

use super::gradient::edge_frame;
use crate::examples::Importance;
use crate::numeric::basis::Basis;
use crate::numeric::columns;
use faer::Mat;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// Rest mesh, and the coordinates of its vertices' and normals' trajectories.
pub struct Surface<'a> {
    /// n, the frames of the trajectories.
    pub frames: usize,
    /// V rest positions.
    pub rest: &'a [[f64; 3]],
    /// Triangles, T, each of some area.
    pub triangles: Vec<[usize; 3]>,
    /// Coordinates of the vertices, r x V.
    pub vertices: &'a Mat<f64>,
    /// n̂ of each triangle, of about an edge's length.
    pub rest_normals: Vec<Vector3<f64>>,
    /// Coordinates of the triangles' normals, r x T, as far as the basis spans them.
    pub normals: Mat<f64>,
    /// How much each vertex counts.
    pub importance: Importance<'a>,
}

impl<'a> Surface<'a> {
    /// Projects a mesh with trajectories (3n x V) on their basis.
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

    /// Returns how much a triangle counts: as its corners do on average.
    pub fn triangle_importance(&self, triangle: usize) -> f64 {
        self.triangles[triangle].map(|vertex| self.importance.of(vertex)).iter().sum::<f64>() / 3.0
    }

    /// Returns the rest edges v̂_k2 and v̂_k3 of a triangle.
    pub fn rest_edges(&self, triangle: usize) -> [Vector3<f64>; 2] {
        let [a, b, c] = self.triangles[triangle].map(|v| Vector3::from(self.rest[v]));
        [b - a, c - a]
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
