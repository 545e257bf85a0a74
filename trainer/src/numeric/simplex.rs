//! Least squares on the simplex: `min |Σ w_j p_j - y|²` with w ≥ 0, Σw = 1.
//!
//! The weights describe the point of least norm in the convex hull of the `p_j - y` (Wolfe 1976). An active set on
//! their Gram matrix finds it.

use super::columns::dot;

/// Largest number of columns in a problem.
pub const MAX_COLUMNS: usize = 16;

/// The Gram matrix of up to [`MAX_COLUMNS`] differences `p_j - y`.
#[derive(Clone, Copy)]
pub struct Gram {
    /// Number of columns in use.
    pub len: usize,
    /// Largest error of the values from rounding; smaller differences count as 0.
    pub noise: f64,
    /// `(p_i - y)·(p_j - y)`.
    pub value: [[f64; MAX_COLUMNS]; MAX_COLUMNS],
}

impl Gram {
    /// Returns the Gram matrix of the selected columns.
    pub fn select(&self, columns: &[usize]) -> Self {
        let mut value = [[0.0; MAX_COLUMNS]; MAX_COLUMNS];
        for (i, &a) in columns.iter().enumerate() {
            for (j, &b) in columns.iter().enumerate() {
                value[i][j] = self.value[a][b];
            }
        }
        Self { len: columns.len(), noise: self.noise, value }
    }

    /// Adds a second matrix, given by its entries.
    pub fn plus(mut self, entry: impl Fn(usize, usize) -> f64) -> Self {
        for i in 0..self.len {
            (0..self.len).for_each(|j| self.value[i][j] += entry(i, j));
        }
        self
    }

    /// Returns the squared error of the weights.
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
    let scale: f64 = (0..n).map(|j| gram.value[j][j]).fold(0.0, f64::max);
    let noise = gram.noise + 1e-12 * scale;
    let mut active = Active { gram, noise, columns: vec![nearest], factor: Vec::new() };
    // Each round lowers the error strictly, so no active set comes back. The cap guards against rounding.
    for _ in 0..4 * n {
        let slopes = active.slopes(&weights);
        let error: f64 = active.columns.iter().map(|&j| weights[j] * slopes[j]).sum();
        let entering = (0..n)
            .filter(|j| !active.columns.contains(j))
            .map(|j| (slopes[j], j))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match entering {
            Some((slope, j)) if slope < error - noise => active.columns.push(j),
            _ => break,
        }
        while let Some(target) = active.affine_minimum() {
            let step = active
                .columns
                .iter()
                .zip(&target)
                .filter(|&(_, &t)| t <= 0.0)
                .map(|(&j, &t)| weights[j] / (weights[j] - t).max(f64::MIN_POSITIVE))
                .fold(1.0, f64::min);
            for (&j, &t) in active.columns.iter().zip(&target) {
                weights[j] += step * (t - weights[j]);
            }
            if step >= 1.0 {
                break;
            }
            active.keep(&mut weights);
        }
    }
    let sum: f64 = weights.iter().sum();
    weights.map(|w| w / sum)
}

/// Solves with at most `most` nonzero weights of at least `least` each: solves, keeps the largest, and solves again.
pub fn solve_sparse(gram: &Gram, most: usize, least: f64) -> [f64; MAX_COLUMNS] {
    let dense = solve(gram);
    let is_kept = |j: &usize| dense[*j] > 0.0 && dense[*j] >= least;
    let mut columns: Vec<usize> = (0..gram.len).filter(is_kept).collect();
    if columns.len() <= most && dense.iter().all(|&w| w == 0.0 || w >= least) {
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

/// The columns with a nonzero weight.
struct Active<'a> {
    gram: &'a Gram,
    /// Added to the diagonal, so that coinciding columns share their weight evenly instead of leaving it undetermined.
    noise: f64,
    columns: Vec<usize>,
    /// Rows of the Cholesky factor of the columns' Gram matrix, packed; row k has k + 1 entries.
    factor: Vec<f64>,
}

impl Active<'_> {
    /// Returns the derivative of half the squared error by each column's weight.
    fn slopes(&self, weights: &[f64; MAX_COLUMNS]) -> [f64; MAX_COLUMNS] {
        let mut slopes = [0.0; MAX_COLUMNS];
        for &j in &self.columns {
            let of = slopes.iter_mut().zip(&self.gram.value[j]);
            of.for_each(|(slope, value)| *slope += weights[j] * value);
        }
        slopes
    }

    /// Removes the columns whose weight has reached zero.
    fn keep(&mut self, weights: &mut [f64; MAX_COLUMNS]) {
        let kept = self.columns.iter().take_while(|&&j| weights[j] > 1e-14).count();
        self.factor.truncate(start(kept));
        self.columns.retain(|&j| {
            let keep = weights[j] > 1e-14;
            if !keep {
                weights[j] = 0.0;
            }
            keep
        });
    }

    /// Minimises over the affine hull of the columns; `None` for fewer than two columns, or if all columns coincide.
    fn affine_minimum(&mut self) -> Option<[f64; MAX_COLUMNS]> {
        let n = self.columns.len();
        if n <= 1 {
            return None;
        }
        while self.factor.len() < start(n) {
            self.factor_further();
        }
        let mut x = [0.0; MAX_COLUMNS];
        for k in 0..n {
            let row = self.row(k);
            x[k] = (1.0 - dot(&row[..k], &x)) / row[k];
        }
        for k in (0..n).rev() {
            let row = self.row(k);
            x[k] /= row[k];
            for j in 0..k {
                x[j] -= row[j] * x[k];
            }
        }
        let sum: f64 = x.iter().sum();
        sum.is_normal().then(|| x.map(|x| x / sum))
    }

    /// Appends the next row of the factor.
    fn factor_further(&mut self) {
        let k = (0..).find(|&k| start(k) == self.factor.len()).unwrap_or(0);
        let own = &self.gram.value[self.columns[k]];
        let mut row = [0.0; MAX_COLUMNS];
        for j in 0..k {
            let known = self.row(j);
            row[j] = (own[self.columns[j]] - dot(&known[..j], &row)) / known[j];
        }
        let pivot = own[self.columns[k]] + self.noise - dot(&row[..k], &row);
        row[k] = pivot.max(self.noise).sqrt();
        self.factor.extend(&row[..=k]);
    }

    fn row(&self, k: usize) -> &[f64] {
        &self.factor[start(k)..=start(k) + k]
    }
}

/// Returns the index at which row k of a packed lower triangle begins.
fn start(k: usize) -> usize {
    k * (k + 1) / 2
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
        let w = solve_sparse(&gram(&corners, [0.01, 0.4, 0.5]), 2, 0.0);
        assert!(w[0] == 0.0 && w[1] == 0.0 && (w[2] - 0.45).abs() < 1e-9);
    }

    #[test]
    fn coinciding_columns_and_pure_rounding_noise_have_a_solution() {
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
