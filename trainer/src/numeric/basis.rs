//! A short orthonormal basis of the surface's trajectories.
//!
//! Proxies, keys and their weights are linear in the trajectories. So all fits can use coordinates on a basis of the
//! trajectories' span. The result is the same up to the basis's residual, and the cost no longer depends on the number
//! of poses.
//!
//! The basis comes from randomised subspace iteration (Halko, Martinsson, Tropp 2011, algorithm 4.4). The iteration
//! reads the trajectories a few times and needs memory linear in V and in N.

use super::columns;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par, Side};
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;

/// Largest number of dimensions of a basis.
const MAX_RANK: usize = 160;
/// RMS residual, in units of the diagonal, below which further dimensions are dropped.
const RESIDUAL: f64 = 1e-5;
/// Number of chunks of columns that are summed in parallel.
const CHUNKS: usize = 16;

/// Orthonormal trajectories, and the vertices' coordinates on them.
pub struct Basis {
    /// Basis trajectories, 3n x r, the strongest first.
    pub vectors: Mat<f64>,
    /// Coordinates of each vertex, r x V.
    pub coordinates: Mat<f64>,
    /// RMS length of the trajectories' part outside the basis.
    pub residual: f64,
}

/// Builds a basis of trajectories (3n x V, in units of the diagonal).
pub fn basis(trajectories: &Mat<f64>) -> Basis {
    basis_of(trajectories.shape().into(), |vertex, out| {
        out.copy_from_slice(trajectories.col_as_slice(vertex));
    })
}

/// Builds a basis of trajectories (3n x V) without holding all of them.
///
/// - `write`: writes the trajectory of one vertex; called once for every pass over the trajectories.
pub fn basis_of([height, vertices]: [usize; 2], write: impl Fn(usize, &mut [f64]) + Sync) -> Basis {
    let part = |start: usize, len: usize| {
        let mut part = Mat::zeros(height, len);
        (0..len).for_each(|k| write(start + k, part.col_as_slice_mut(k)));
        part
    };
    let sketch = height.min(MAX_RANK + 16);
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(0);
    let signs =
        Mat::from_fn(vertices, sketch, |_, _| if random.random::<bool>() { 1.0 } else { -1.0 });
    let mut range = sum_over_chunks(height, sketch, vertices, |start, len, out| {
        let part = part(start, len);
        matmul(out.as_mut(), Accum::Add, part, signs.subrows(start, len), 1.0, Par::Seq);
    });
    drop(signs);
    for _ in 0..2 {
        let q = range.qr().compute_thin_Q();
        range = sum_over_chunks(height, sketch, vertices, |start, len, out| {
            let part = part(start, len);
            let onto = part.transpose() * &q;
            matmul(out.as_mut(), Accum::Add, part, &onto, 1.0, Par::Seq);
        });
    }
    let q = range.qr().compute_thin_Q();
    let gram = sum_over_chunks(sketch, sketch, vertices, |start, len, out| {
        let onto = q.transpose() * part(start, len);
        matmul(out.as_mut(), Accum::Add, &onto, onto.transpose(), 1.0, Par::Seq);
    });
    let squares = (0..vertices).into_par_iter().map(|vertex| part(vertex, 1).squared_norm_l2());
    let total: f64 = squares.collect::<Vec<_>>().iter().sum();
    let frames = (height / 3).max(1) as f64;
    let rms = |left: f64| (left.max(0.0) / (frames * vertices.max(1) as f64)).sqrt();
    let (vectors, left) = match gram.self_adjoint_eigen(Side::Lower) {
        Ok(eigen) => {
            let energy = |i: usize| eigen.S().column_vector()[sketch - 1 - i].max(0.0);
            let (mut rank, mut left) = (1, total - energy(0));
            while rank < sketch.min(MAX_RANK) && rms(left) > RESIDUAL {
                left -= energy(rank);
                rank += 1;
            }
            (&q * eigen.U().reverse_cols().subcols(0, rank), left)
        }
        // The Gram matrix of finite trajectories always has a decomposition. If it fails, q itself is a basis.
        Err(_) => (q, 0.0),
    };
    let mut coordinates = Mat::zeros(vectors.ncols(), vertices);
    columns::fill(&mut coordinates, |vertex, out| {
        let own = part(vertex, 1);
        for (value, direction) in out.iter_mut().zip(vectors.col_iter()) {
            *value = direction.transpose() * own.col(0);
        }
    });
    Basis { vectors, coordinates, residual: rms(left) }
}

/// Sums over fixed chunks of columns in a fixed order, for any number of threads.
fn sum_over_chunks(
    rows: usize,
    columns: usize,
    items: usize,
    add: impl Fn(usize, usize, &mut Mat<f64>) + Sync,
) -> Mat<f64> {
    let chunk = items.div_ceil(CHUNKS).max(1);
    let part = |number: usize| {
        let mut part = Mat::zeros(rows, columns);
        let start = number * chunk;
        add(start, chunk.min(items - start), &mut part);
        part
    };
    let parts = (0..items.div_ceil(chunk)).into_par_iter().map(part);
    let parts: Vec<Mat<f64>> = parts.collect();
    let mut sum = Mat::zeros(rows, columns);
    for part in &parts {
        sum += part;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_give_back_the_trajectories_to_the_stated_residual() {
        let (frames, vertices) = (60, 400);
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        // A smooth motion of few dimensions, and noise below the residual at which a basis ends.
        let moved = Mat::from_fn(3 * frames, vertices, |i, j| {
            let noise: f64 = random.random_range(-4e-6..4e-6);
            1.0 / (1.0 + i as f64 / 180.0 + j as f64 / 400.0) + noise
        });
        let basis = basis(&moved);
        let rank = basis.vectors.ncols();
        let gram = basis.vectors.transpose() * &basis.vectors;
        assert!((gram - Mat::<f64>::identity(rank, rank)).norm_max() < 1e-12);
        let left = &moved - &basis.vectors * &basis.coordinates;
        let rms = left.norm_l2() / ((frames * vertices) as f64).sqrt();
        assert!((rms - basis.residual).abs() < 1e-3 * basis.residual + 1e-9, "{rms}");
        assert!(rms < 2.0 * RESIDUAL && rank < moved.nrows());
    }

    #[test]
    fn few_dimensions_are_found_exactly() {
        let moved = Mat::from_fn(30, 50, |i, j| {
            (i as f64).sin() * j as f64 + (i as f64).cos() * (j as f64).sqrt()
        });
        let basis = basis(&moved);
        assert_eq!(basis.vectors.ncols(), 2);
        assert!((moved - &basis.vectors * &basis.coordinates).norm_max() < 1e-9);
    }
}
