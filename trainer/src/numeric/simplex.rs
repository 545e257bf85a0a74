//! Least squares on the simplex: `min |Σ w_j p_j - y|²` with w ≥ 0, Σw = 1.
//!
//! This is the point of least norm in the convex hull of the `p_j - y` (Wolfe 1976), solved by an
//! active set on their Gram matrix.

/// Most columns one problem may have.
pub const MAX_COLUMNS: usize = 16;

/// The Gram matrix of up to [`MAX_COLUMNS`] differences `p_j - y`.
#[derive(Clone, Copy)]
pub struct Gram {
    /// Number of columns in use.
    pub len: usize,
    /// How far rounding may have moved the values; differences below it are none.
    pub noise: f64,
    /// `(p_i - y)·(p_j - y)`.
    pub value: [[f64; MAX_COLUMNS]; MAX_COLUMNS],
}

impl Gram {
    /// Returns the Gram matrix of some of the columns.
    pub fn select(&self, columns: &[usize]) -> Self {
        let mut value = [[0.0; MAX_COLUMNS]; MAX_COLUMNS];
        for (i, &a) in columns.iter().enumerate() {
            for (j, &b) in columns.iter().enumerate() {
                value[i][j] = self.value[a][b];
            }
        }
        Self { len: columns.len(), noise: self.noise, value }
    }

    /// Returns the squared error of weights.
    pub fn error(&self, weights: &[f64; MAX_COLUMNS]) -> f64 {
        let n = self.len;
        let sum: f64 = (0..n).map(|i| weights[i] * self.apply(weights, i)).sum();
        sum.max(0.0)
    }

    fn apply(&self, weights: &[f64; MAX_COLUMNS], row: usize) -> f64 {
        (0..self.len).map(|j| self.value[row][j] * weights[j]).sum()
    }
}

/// Solves for the weights of all columns.
pub fn solve(gram: &Gram) -> [f64; MAX_COLUMNS] {
    let n = gram.len;
    let mut weights = [0.0; MAX_COLUMNS];
    let Some(nearest) = (0..n).min_by(|&a, &b| gram.value[a][a].total_cmp(&gram.value[b][b]))
    else {
        return weights;
    };
    weights[nearest] = 1.0;
    let mut active = vec![nearest];
    let scale: f64 = (0..n).map(|j| gram.value[j][j]).fold(0.0, f64::max);
    let noise = gram.noise + 1e-12 * scale;
    // Each round lowers the error strictly, so no active set comes back; the cap guards rounding.
    for _ in 0..4 * n {
        let error = gram.error(&weights);
        let entering = (0..n)
            .filter(|j| !active.contains(j))
            .map(|j| (gram.apply(&weights, j), j))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match entering {
            Some((slope, j)) if slope < error - noise => active.push(j),
            _ => break,
        }
        while let Some(target) = affine_minimum(gram, &active) {
            let step = active
                .iter()
                .zip(&target)
                .filter(|&(_, &t)| t <= 0.0)
                .map(|(&j, &t)| weights[j] / (weights[j] - t).max(f64::MIN_POSITIVE))
                .fold(1.0, f64::min);
            for (&j, &t) in active.iter().zip(&target) {
                weights[j] += step * (t - weights[j]);
            }
            if step >= 1.0 {
                break;
            }
            active.retain(|&j| {
                let keep = weights[j] > 1e-14;
                if !keep {
                    weights[j] = 0.0;
                }
                keep
            });
        }
    }
    let sum: f64 = weights.iter().sum();
    weights.map(|w| w / sum)
}

/// Solves with at most `most` weights not zero: solve, keep the strongest, solve again.
pub fn solve_sparse(gram: &Gram, most: usize) -> [f64; MAX_COLUMNS] {
    let dense = solve(gram);
    let mut columns: Vec<usize> = (0..gram.len).filter(|&j| dense[j] > 0.0).collect();
    if columns.len() <= most {
        return dense;
    }
    columns.sort_by(|&a, &b| dense[b].total_cmp(&dense[a]).then(a.cmp(&b)));
    columns.truncate(most);
    let kept = solve(&gram.select(&columns));
    let mut weights = [0.0; MAX_COLUMNS];
    for (i, &j) in columns.iter().enumerate() {
        weights[j] = kept[i];
    }
    weights
}

/// Minimises over the affine hull of the active columns; `None` once at most one is left, or where
/// they do not differ.
fn affine_minimum(gram: &Gram, active: &[usize]) -> Option<Vec<f64>> {
    let n = active.len();
    if n <= 1 {
        return None;
    }
    let mut a = gram.select(active);
    let trace: f64 = (0..n).map(|i| a.value[i][i]).sum();
    for i in 0..n {
        // Columns that coincide leave the weights free between them: share them evenly.
        a.value[i][i] += gram.noise + 1e-12 * trace;
    }
    let mut x = vec![1.0; n];
    for k in 0..n {
        for j in 0..k {
            let factor = a.value[k][j];
            for i in k..n {
                a.value[i][k] -= a.value[i][j] * factor;
            }
        }
        let pivot = a.value[k][k].max(gram.noise + 1e-14 * trace).sqrt();
        for i in k..n {
            a.value[i][k] /= pivot;
        }
        a.value[k][k] = pivot;
    }
    for k in 0..n {
        for j in 0..k {
            x[k] -= a.value[k][j] * x[j];
        }
        x[k] /= a.value[k][k];
    }
    for k in (0..n).rev() {
        for j in k + 1..n {
            x[k] -= a.value[j][k] * x[j];
        }
        x[k] /= a.value[k][k];
    }
    let sum: f64 = x.iter().sum();
    if !sum.is_normal() {
        return None;
    }
    Some(x.into_iter().map(|v| v / sum).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gram(points: &[[f64; 3]], y: [f64; 3]) -> Gram {
        let d: Vec<[f64; 3]> =
            points.iter().map(|p| [p[0] - y[0], p[1] - y[1], p[2] - y[2]]).collect();
        let mut value = [[0.0; MAX_COLUMNS]; MAX_COLUMNS];
        for i in 0..d.len() {
            for j in 0..d.len() {
                value[i][j] = (0..3).map(|k| d[i][k] * d[j][k]).sum();
            }
        }
        Gram { len: d.len(), noise: 0.0, value }
    }

    #[test]
    fn a_point_inside_a_tetrahedron_has_its_barycentric_coordinates() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let w = solve(&gram(&corners, [0.1, 0.2, 0.3]));
        for (found, expected) in w.iter().zip([0.4, 0.1, 0.2, 0.3]) {
            assert!((found - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn a_point_outside_lands_on_the_nearest_face() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let g = gram(&corners, [0.25, 0.25, -2.0]);
        let w = solve(&g);
        for (found, expected) in w.iter().zip([0.5, 0.25, 0.25, 0.0]) {
            assert!((found - expected).abs() < 1e-9);
        }
        assert!((g.error(&w) - 4.0).abs() < 1e-9);
    }

    #[test]
    fn the_optimum_satisfies_its_conditions_on_seeded_problems() {
        use rand::{RngExt, SeedableRng};
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        for _ in 0..500 {
            let n = random.random_range(1..=12);
            let mut point = || std::array::from_fn(|_| random.random_range(-1.0..1.0));
            let points: Vec<[f64; 3]> = (0..n).map(|_| point()).collect();
            let target = point();
            let g = gram(&points, target);
            let w = solve(&g);
            assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(w.iter().all(|&x| x >= 0.0));
            let error = g.error(&w);
            for j in 0..n {
                assert!(g.apply(&w, j) >= error - 1e-9, "column {j} would lower the error");
            }
        }
    }

    #[test]
    fn pruning_keeps_the_strongest_and_solves_again() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let w = solve_sparse(&gram(&corners, [0.01, 0.4, 0.5]), 2);
        assert!(w[0] == 0.0 && w[1] == 0.0 && (w[2] - 0.45).abs() < 1e-9);
    }

    #[test]
    fn coinciding_columns_and_nothing_but_rounding_are_no_trouble() {
        let mut noise = gram(&[[0.0; 3]; 12], [0.0; 3]);
        for i in 0..12 {
            for j in 0..12 {
                noise.value[i][j] = 1e-17 * ((5 * i * j + 3 * (i + j)) as f64).sin();
            }
        }
        noise.noise = 1e-15;
        for g in [gram(&[[1.0, 0.0, 0.0]; 3], [0.0; 3]), gram(&[[0.0; 3]; 3], [0.0; 3]), noise] {
            let w = solve(&g);
            assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12 && w.iter().all(|&x| x >= 0.0));
        }
    }
}
