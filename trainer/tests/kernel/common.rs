//! Points, functions and files that several of these tests use.

use faer::Mat;
use models::shared;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use sinew_trainer::scattered::solver::samples::{Conflicts, Samples};
use sinew_trainer::scattered::solver::scaling::Block;
use sinew_trainer::scattered::sum::KernelSum;
use std::fs;

/// Reads a JSON file of the shared data.
pub(crate) fn json(file: &str) -> Option<Value> {
    let text = fs::read_to_string(shared(file)?).unwrap();
    Some(serde_json::from_str(&text).unwrap())
}

/// Reads a list of numbers as a column, or a list of lists as rows.
pub(crate) fn matrix(value: &Value) -> Mat<f64> {
    let rows: Vec<Vec<f64>> = value.as_array().unwrap().iter().map(numbers).collect();
    Mat::from_fn(rows.len(), rows[0].len(), |i, c| rows[i][c])
}

/// Reads a number or a list of numbers.
pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    match value.as_array() {
        Some(list) => list.iter().map(|x| x.as_f64().unwrap()).collect(),
        None => vec![value.as_f64().unwrap()],
    }
}

/// Returns n points of the Halton sequence from element `from` on, n x d.
pub(crate) fn halton(from: usize, n: usize, d: usize) -> Mat<f64> {
    const PRIMES: [usize; 5] = [2, 3, 5, 7, 11];
    Mat::from_fn(n, d, |i, c| {
        let (mut left, mut value, mut place) = (from + i, 0.0, 1.0);
        while left > 0 {
            place /= PRIMES[c] as f64;
            value += place * (left % PRIMES[c]) as f64;
            left /= PRIMES[c];
        }
        value
    })
}

/// Draws numbers between -1 and 1, n x d.
pub(crate) fn random(seed: u64, n: usize, d: usize) -> Mat<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    Mat::from_fn(n, d, |_, _| 2.0 * random.random::<f64>() - 1.0)
}

/// Franke's function.
pub(crate) fn franke(x: f64, y: f64) -> f64 {
    let (x, y) = (9.0 * x, 9.0 * y);
    let bump = |height: f64, a: f64| height * (-a).exp();
    bump(0.75, ((x - 2.0).powi(2) + (y - 2.0).powi(2)) / 4.0)
        + bump(0.75, (x + 1.0).powi(2) / 49.0 + (y + 1.0) / 10.0)
        + bump(0.5, ((x - 7.0).powi(2) + (y - 3.0).powi(2)) / 4.0)
        - bump(0.2, (x - 4.0).powi(2) + (y - 7.0).powi(2))
}

/// Wahba's function.
pub(crate) fn wahba(x: f64) -> f64 {
    4.26 * ((-x).exp() - 4.0 * (-2.0 * x).exp() + 3.0 * (-3.0 * x).exp())
}

/// Evaluates Franke's function at points, n x 1.
pub(crate) fn franke_at(points: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(points.nrows(), 1, |i, _| franke(points[(i, 0)], points[(i, 1)]))
}

/// Evaluates Wahba's function at points, n x 1.
pub(crate) fn wahba_at(points: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(points.nrows(), 1, |i, _| wahba(points[(i, 0)]))
}

/// Makes samples with scalar inputs.
pub(crate) fn samples(sites: &Mat<f64>, values: &Mat<f64>) -> Samples {
    let blocks = vec![Block { len: 1, weight: 1.0 }; sites.ncols()];
    Samples::new(sites, values, &blocks, Conflicts::Refuse).unwrap()
}

/// Evaluates a function at queries, q x m.
pub(crate) fn evaluate(sum: &KernelSum, queries: &Mat<f64>) -> Mat<f64> {
    let rows: Vec<Vec<f64>> = rows(queries).iter().map(|x| sum.evaluate(x)).collect();
    Mat::from_fn(rows.len(), sum.value_len(), |i, o| rows[i][o])
}

/// Returns the rows of a matrix.
pub(crate) fn rows(of: &Mat<f64>) -> Vec<Vec<f64>> {
    of.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// Returns the largest difference of two matrices; empty matrices fail.
pub(crate) fn apart(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    assert_eq!(a.shape(), b.shape());
    assert!(a.nrows() * a.ncols() > 0);
    let all = rows(a).concat().into_iter().zip(rows(b).concat());
    all.fold(0.0, |most, (a, b)| if (a - b).abs() <= most { most } else { (a - b).abs() })
}
