//! Full Poisson reconstruction: vertices from the gradients of all triangles (METHOD §1.6, S3 §2.1, §2.2, Eq. 1 and 2).
//! The reduced reconstruction is tested against it.

use crate::Error;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::Llt;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use nalgebra::{Matrix3, Vector3};

/// The factored system of one mesh and one set F.
pub struct Poisson {
    rest: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
    /// Index of each vertex among the free vertices, V; `None` for F.
    unknown: Vec<Option<usize>>,
    factor: Llt<usize, f64>,
}

impl Poisson {
    /// Factors the system.
    ///
    /// - `fixed`: F, V flags; vertices without a triangle must belong to F.
    ///
    /// # Errors
    /// - A connected part has no vertex in F; see [`floating`].
    /// - The sparse factorisation failed: out of memory, or rounding.
    pub fn new(rest: &[[f64; 3]], triangles: &[[usize; 3]], fixed: &[bool]) -> Result<Self, Error> {
        let mut free = 0..;
        let number = |&fixed: &bool| if fixed { None } else { free.next() };
        let unknown: Vec<Option<usize>> = fixed.iter().map(number).collect();
        let count = unknown.iter().flatten().count();
        if let Some(vertex) = floating(triangles, fixed) {
            return Err(Error::fit(format!(
                "vertex {vertex} is joined to no near-rigid vertex, so its position is not determined"
            )));
        }
        let mut entries = Vec::new();
        for [first, last] in edges(triangles) {
            let (a, b) = (unknown[first], unknown[last]);
            for end in [a, b].into_iter().flatten() {
                entries.push(Triplet::new(end, end, 1.0));
            }
            if let (Some(a), Some(b)) = (a, b) {
                entries.push(Triplet::new(a, b, -1.0));
                entries.push(Triplet::new(b, a, -1.0));
            }
        }
        // Every connected part has a vertex in F, so the graph Laplacian of the free vertices is positive definite.
        let failed = || {
            Error::fit(format!("the sparse system of {count} free vertices could not be factored"))
        };
        let factor = SparseColMat::try_new_from_triplets(count, count, &entries)
            .ok()
            .and_then(|matrix| matrix.sp_cholesky(Side::Lower).ok())
            .ok_or_else(failed)?;
        Ok(Self { rest: rest.to_vec(), triangles: triangles.to_vec(), unknown, factor })
    }

    /// Reconstructs V positions.
    ///
    /// - `gradients`: of the triangles, T.
    /// - `positions`: V; only the positions of F are read.
    pub fn reconstruct(
        &self,
        gradients: &[Matrix3<f64>],
        positions: &[Vector3<f64>],
    ) -> Vec<Vector3<f64>> {
        let free = self.unknown.iter().flatten().count();
        let mut right = Mat::<f64>::zeros(free, 3);
        for (edge, [first, last]) in edges(&self.triangles).enumerate() {
            let rest = Vector3::from(self.rest[last]) - Vector3::from(self.rest[first]);
            let posed = gradients[edge / 2] * rest;
            for (end, other, sign) in [(last, first, 1.0), (first, last, -1.0)] {
                let Some(row) = self.unknown[end] else { continue };
                let known = match self.unknown[other] {
                    Some(_) => Vector3::zeros(),
                    None => positions[other],
                };
                for axis in 0..3 {
                    right[(row, axis)] += sign * posed[axis] + known[axis];
                }
            }
        }
        let solved = self.factor.solve(right);
        self.unknown
            .iter()
            .zip(positions)
            .map(|(unknown, known)| match unknown {
                Some(row) => Vector3::from_fn(|axis, _| solved[(*row, axis)]),
                None => *known,
            })
            .collect()
    }
}

/// Lists the edges (1, 2) and (1, 3) of every triangle.
fn edges(triangles: &[[usize; 3]]) -> impl Iterator<Item = [usize; 2]> + '_ {
    triangles.iter().flat_map(|&[a, b, c]| [[a, b], [a, c]])
}

/// Finds a vertex that no chain of edges joins to F, so that its position is not determined.
///
/// - `fixed`: F, V flags.
pub fn floating(triangles: &[[usize; 3]], fixed: &[bool]) -> Option<usize> {
    let mut joined = fixed.to_vec();
    loop {
        let mut changed = false;
        for [a, b] in edges(triangles) {
            if joined[a] != joined[b] {
                (joined[a], joined[b]) = (true, true);
                changed = true;
            }
        }
        if !changed {
            return joined.iter().position(|&j| !j);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::s3::surface::gradient;
    use crate::examples::demo::{DemoOptions, demo};

    #[test]
    fn true_gradients_and_one_fixed_vertex_a_part_give_back_the_posed_mesh() {
        let examples = demo(&DemoOptions { vertices: 400, poses: 4, held_out: 0, seed: 9 });
        let (rest, triangles) = (&examples.rest, &examples.triangles);
        let mut fixed = vec![false; rest.len()];
        while let Some(vertex) = floating(triangles, &fixed) {
            fixed[vertex] = true;
        }
        let system = Poisson::new(rest, triangles, &fixed).unwrap();
        for frame in 0..4 {
            let posed = examples.frame(frame);
            let gradients: Vec<_> = triangles
                .iter()
                .map(|t| gradient(t.map(|v| &rest[v]), t.map(|v| &posed[v])).unwrap())
                .collect();
            let known: Vec<_> = posed
                .iter()
                .zip(&fixed)
                .map(|(y, &f)| if f { Vector3::from(*y) } else { Vector3::repeat(1e9) })
                .collect();
            let found = system.reconstruct(&gradients, &known);
            for (y, expected) in found.iter().zip(posed) {
                assert!((y - Vector3::from(*expected)).norm() < 1e-9);
            }
        }
    }

    #[test]
    fn a_part_without_a_fixed_vertex_is_named() {
        let rest: Vec<[f64; 3]> = (0..6).map(|i| [f64::from(i), f64::from(i * i), 0.0]).collect();
        let found = Poisson::new(
            &rest,
            &[[0, 1, 2], [3, 4, 5]],
            &[true, false, false, false, false, false],
        );
        let error = found.err().unwrap();
        assert!(
            error.message().starts_with("vertex 3 is joined to no near-rigid vertex"),
            "{error}"
        );
    }
}
