//! Groups of points that are alike: k-means with seeds drawn by squared distance.

use faer::Mat;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;

const ROUNDS: usize = 30;

/// Splits the columns of `points` (d x n) into at most `count` groups; returns each one's group.
///
/// Seeded, so that the same points give the same groups.
pub fn cluster(points: &Mat<f64>, count: usize) -> Vec<usize> {
    let mut centres = seeds(points, count);
    let mut group = vec![0; points.ncols()];
    for _ in 0..ROUNDS {
        let next: Vec<usize> = (0..points.ncols())
            .into_par_iter()
            .map(|i| nearest(points.col_as_slice(i), &centres).0)
            .collect();
        if next == group {
            break;
        }
        group = next;
        let mut sums = vec![(0usize, vec![0.0; points.nrows()]); centres.len()];
        for (i, &g) in group.iter().enumerate() {
            sums[g].0 += 1;
            sums[g].1.iter_mut().zip(points.col_as_slice(i)).for_each(|(s, x)| *s += x);
        }
        for (centre, (members, sum)) in centres.iter_mut().zip(sums) {
            if members > 0 {
                *centre = sum.into_iter().map(|s| s / members as f64).collect();
            }
        }
    }
    group
}

/// Draws each next centre with a probability as its squared distance from those before.
fn seeds(points: &Mat<f64>, count: usize) -> Vec<Vec<f64>> {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let n = points.ncols();
    let mut centres = vec![points.col_as_slice(random.random_range(0..n)).to_vec()];
    let mut distances = vec![f64::INFINITY; n];
    while centres.len() < count.min(n) {
        let last = &centres[centres.len() - 1];
        for (i, distance) in distances.iter_mut().enumerate() {
            *distance = distance.min(squared(points.col_as_slice(i), last));
        }
        let total: f64 = distances.iter().sum();
        if total <= 0.0 {
            break;
        }
        let mut left = random.random_range(0.0..total);
        let chosen = distances.iter().position(|d| {
            left -= d;
            left < 0.0
        });
        centres.push(points.col_as_slice(chosen.unwrap_or(n - 1)).to_vec());
    }
    centres
}

fn nearest(point: &[f64], centres: &[Vec<f64>]) -> (usize, f64) {
    centres
        .iter()
        .map(|centre| squared(point, centre))
        .enumerate()
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((0, 0.0))
}

fn squared(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_apart_are_groups_apart() {
        let points = Mat::from_fn(2, 30, |r, i| (i / 10 * 10) as f64 + 0.1 * ((r + i) % 7) as f64);
        let group = cluster(&points, 3);
        for i in 0..30 {
            for j in 0..30 {
                assert_eq!(group[i] == group[j], i / 10 == j / 10, "{i} {j}");
            }
        }
    }

    #[test]
    fn there_are_no_more_groups_than_points_that_differ() {
        let points = Mat::from_fn(2, 8, |_, i| (i % 2) as f64);
        let group = cluster(&points, 5);
        assert!(group.iter().all(|&g| g < 2) && group[0] != group[1] && group[0] == group[2]);
    }
}
