//! Samples of known functions, initial options, and the reference's figures. The functions use
//! libm, so they are equal on all CPUs.

use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use sinew_runtime::kernel::Kernel;
use sinew_trainer::Error;
use sinew_trainer::scattered::hyper::{Entries, Learned, Method, Metric, Options, Start, learn};
use sinew_trainer::scattered::sum::KernelSum;
use std::path::Path;

/// Samples of a function.
pub(crate) struct Problem {
    /// N x d sites in the unit box.
    pub(crate) sites: Mat<f64>,
    /// N x 1 values.
    pub(crate) values: Mat<f64>,
}

impl Problem {
    /// Draws samples.
    pub(crate) fn new(seed: u64, count: usize, inputs: usize, of: fn(&[f64]) -> f64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let drawn: Vec<f64> = (0..count * inputs).map(|_| random.random()).collect();
        let sites = Mat::from_fn(count, inputs, |r, c| drawn[inputs * r + c]);
        let values = Mat::from_fn(count, 1, |r, _| of(&drawn[inputs * r..][..inputs]));
        Self { sites, values }
    }

    /// Franke's function.
    pub(crate) fn franke(seed: u64, count: usize) -> Self {
        Self::new(seed, count, 2, franke)
    }

    /// Learns with inputs relative to the middle of the box.
    pub(crate) fn learn(&self, options: &Options) -> Result<Learned, Error> {
        let inputs = self.sites.ncols();
        let (shift, scale) = (vec![0.5; inputs], vec![1.0; inputs]);
        learn(self.sites.as_ref(), self.values.as_ref(), &shift, &scale, options)
    }

    /// Returns the RMS error of a function.
    pub(crate) fn rms(&self, sum: &KernelSum) -> f64 {
        let rows = self.sites.row_iter().zip(self.values.row_iter());
        let squares = rows.map(|(site, value)| {
            let site: Vec<f64> = site.iter().copied().collect();
            (sum.evaluate(&site)[0] - value[0]).powi(2)
        });
        (squares.sum::<f64>() / self.sites.nrows() as f64).sqrt()
    }
}

/// Returns options for gaussians with a diagonal metric, whose width starts at a quarter of the
/// box, and one seed.
pub(crate) fn options(inputs: usize, centres: usize) -> Options {
    Options {
        kernel: Kernel::Gaussian,
        centres,
        degree: None,
        ridge: 1e-9,
        metric: Metric::scaled(inputs, inputs, 4.0, Entries::Diagonal),
        start: Start::KMeansPlusPlus,
        method: Method::VariableProjection,
        seeds: vec![1],
        evaluations: 1000,
    }
}

/// Franke's function (1979): two hills, a ridge and a dip in the unit square.
fn franke(x: &[f64]) -> f64 {
    let [a, b] = [9.0 * x[0], 9.0 * x[1]];
    let hill = |x: f64, y: f64, x_width: f64, y_width: f64| {
        libm::exp(-(a - x) * (a - x) / x_width - (b - y) * (b - y) / y_width)
    };
    let ridge = libm::exp(-(a + 1.0) * (a + 1.0) / 49.0 - (b + 1.0) / 10.0);
    0.75 * hill(2.0, 2.0, 4.0, 4.0) + 0.75 * ridge + 0.5 * hill(7.0, 3.0, 4.0, 4.0)
        - 0.2 * hill(4.0, 7.0, 1.0, 1.0)
}

/// Reads `hbf_reference.json`; `None` without shared data, which continuous integration must have.
pub(crate) fn reference() -> Option<Value> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/reference");
    let file = folder.join("hbf_reference.json");
    if file.exists() {
        return Some(serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap());
    }
    assert!(std::env::var_os("CI").is_none(), "hbf_reference.json must be in ../shared/reference");
    eprintln!("hbf_reference.json is not in ../shared/reference: not tested");
    None
}

/// Returns a list of figures.
pub(crate) fn figures(list: &Value) -> Vec<f64> {
    list.as_array().unwrap().iter().map(|figure| figure.as_f64().unwrap()).collect()
}

/// Returns the median of an even number of figures.
pub(crate) fn median(mut figures: Vec<f64>) -> f64 {
    figures.sort_by(f64::total_cmp);
    let half = figures.len() / 2;
    0.5 * (figures[half - 1] + figures[half])
}
