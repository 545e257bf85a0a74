//! The Jacobian and the variance against f64.

use super::exact::{Exact, kernel};
use super::{jacobian, variance, with};
use crate::common::apart;
use models::{KernelContent, Rng};
use sinew_runtime::kernel::{Kernel, QueryRule};

fn double(query: &[f32]) -> Vec<f64> {
    query.iter().map(|x| f64::from(*x)).collect()
}

/// Compares the Jacobian with central differences of f64 values; returns the number of zeros.
fn compare(content: &KernelContent, query: &[f32]) -> usize {
    let found = with(content, |map| jacobian(&map, query).unwrap());
    let row = query.len();
    let mut zeros = 0;
    for column in 0..row {
        let h = 1e-6;
        let at = |h: f64| {
            let mut query = double(query);
            query[column] += h;
            Exact::new(content, &query).values
        };
        let (after, before) = (at(h), at(-h));
        for (value, (after, before)) in after.iter().zip(&before).enumerate() {
            let expected = (after - before) / (2.0 * h);
            let found = f64::from(found[value * row + column]);
            let tolerance = 2e-5 * (1.0 + expected.abs());
            assert!((found - expected).abs() <= tolerance, "{value} {column} {found} {expected}");
            zeros += usize::from(found == 0.0);
        }
    }
    zeros
}

#[test]
fn derivatives_are_those_of_the_values() {
    let mut rng = Rng(5);
    for kernel in Kernel::ALL.into_iter().step_by(apart(5)) {
        let mut content = KernelContent::every(kernel);
        // Rotations of length about 1, for derivatives of about 1.
        let mut query = content.query(&mut rng, 0.6);
        query[4..].chunks_mut(4).for_each(|q| q[3] += 0.8);
        assert!(compare(&content, &query) < 100);
        content.metric.clear();
        content.centres = content
            .centres
            .iter()
            .map(|t| t.iter().cycle().take(25).map(|x| x * 0.5).collect())
            .collect();
        compare(&content, &query);
    }
}

#[test]
fn a_feature_at_the_end_of_its_range_does_not_change() {
    let mut content = KernelContent::every(Kernel::Cubic);
    content.rule.query = QueryRule::Clamp;
    let mut query = content.query(&mut Rng(8), 0.6);
    query[4..].chunks_mut(4).for_each(|q| q[3] += 0.8);
    // The scalar is out of range, so its column is 0.
    query[0] = 0.9;
    let zeros = compare(&content, &query);
    assert!(zeros >= 9, "{zeros}");
    query[0] = 0.1;
    assert_eq!(compare(&content, &query) + 9, zeros);
}

#[test]
fn on_a_centre_a_cone_has_no_slope() {
    for kernel in Kernel::ALL {
        let content = KernelContent::plain(kernel, [3, 1, 2]);
        let query = content.centres[0].clone();
        let found = with(&content, |map| jacobian(&map, &query).unwrap());
        assert_eq!(found, [0.0; 6], "{kernel:?}");
    }
}

#[test]
fn variances_are_those_of_their_closed_form() {
    let mut rng = Rng(23);
    let mut clipped = 0;
    for k in Kernel::ALL.into_iter().step_by(apart(4)) {
        let content = KernelContent::every(k);
        let stored = content.variance.as_ref().unwrap();
        with(&content, |map| {
            assert!(map.has_variance());
            for _ in 0..20 / apart(10) {
                let query = content.query(&mut rng, 0.6);
                let exact = Exact::new(&content, &double(&query));
                let g: Vec<f64> = exact.s.iter().map(|s| kernel(k, *s)).collect();
                let p = &exact.terms;
                let times = |rows: &[Vec<f32>], x: &[f64]| {
                    let row =
                        |row: &Vec<f32>| row.iter().zip(x).map(|(a, x)| f64::from(*a) * x).sum();
                    rows.iter().map(row).collect::<Vec<f64>>()
                };
                let inner = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
                let explained = times(&stored.factor, &[g.as_slice(), p].concat());
                let share = kernel(k, 0.0) - 2.0 * inner(&g, &times(&stored.mixed, p))
                    + inner(p, &times(&stored.polynomial, p))
                    - inner(&explained, &explained);
                let size = 1.0 + inner(&g, &g) + inner(p, p);
                clipped += usize::from(share < 0.0);
                let found = variance(&map, &query).unwrap();
                assert_eq!(found.len(), 9);
                for (found, deviation) in found.iter().zip(&stored.deviations) {
                    let square = f64::from(*deviation).powi(2);
                    let expected = share.max(0.0) * square;
                    let apart = (f64::from(*found) - expected).abs();
                    assert!(apart <= 1e-5 * size * square, "{k:?} {found} {expected}");
                }
            }
        });
    }
    assert!(cfg!(miri) || clipped > 0);
}
