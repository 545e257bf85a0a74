//! How far samples are from their nearest ones.

use super::matrix::distances;
use super::samples::{ONE_SITE, Samples};

/// Distances between nearest samples, over the mean distance of all.
pub struct Spacing {
    /// From a sample to the nearest other site, on average; 0 of a single site.
    pub mean: f64,
    /// Of the two nearest samples; infinite of a single one.
    pub least: f64,
    /// The two nearest samples.
    pub nearest: [usize; 2],
}

impl Spacing {
    /// Measures samples.
    pub fn new(samples: &Samples) -> Self {
        let points = samples.scaling.apply(&samples.sites);
        let n = points.nrows();
        let mut others = vec![f64::INFINITY; n];
        let (mut least, mut nearest) = (f64::INFINITY, [0; 2]);
        for from in 0..n {
            for (at, distance) in (from..n).zip(distances(&points, from)).skip(1) {
                if distance < least {
                    (least, nearest) = (distance, [from, at]);
                }
                if distance >= ONE_SITE {
                    others[from] = others[from].min(distance);
                    others[at] = others[at].min(distance);
                }
            }
        }
        let known = others.iter().filter(|distance| distance.is_finite());
        let mean = known.clone().sum::<f64>() / known.count().max(1) as f64;
        Self { mean, least, nearest }
    }
}
