//! Processes, their samples, and other models of these samples.

use faer::{Mat, Side};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_trainer::signal::covariance::Covariance;
use sinew_trainer::signal::functional::Functional;
use sinew_trainer::signal::kriging::Mean;
use sinew_trainer::signal::kriging::{Process, gram};
use sinew_trainer::signal::table::Table;

/// Makes a process without noise.
pub(crate) fn process(covariance: Covariance, mean: Mean) -> Process {
    Process { covariance, mean, noise: 0.0 }
}

pub(crate) fn values(places: &[f64]) -> Vec<Functional> {
    places.iter().map(|&at| Functional::Value { at }).collect()
}

/// Lists one covariance of each family.
pub(crate) fn families() -> Vec<Covariance> {
    vec![
        Covariance::SquaredExponential { length: 0.9 },
        Covariance::OrnsteinUhlenbeck { length: 3.0 },
        Covariance::Matern32 { length: 2.0 },
        Covariance::Matern52 { length: 1.5 },
        Covariance::Oscillating { length: 4.0, period: 2.6 },
        Covariance::Table(Table::new(&[1.0, 0.7, 0.2, -0.1, -0.2, -0.1], 1.0).unwrap().0),
    ]
}

/// Normal numbers from a seed.
pub(crate) struct Numbers(ChaCha8Rng);

impl Numbers {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn uniform(&mut self) -> f64 {
        ((self.0.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    pub(crate) fn normal(&mut self) -> f64 {
        let (a, b) = (self.uniform(), self.uniform());
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }
}

/// Draws functions of a process at given places, by a factor of their covariance.
pub(crate) struct Drawn {
    factor: Mat<f64>,
}

impl Drawn {
    pub(crate) fn new(covariance: &Covariance, places: &[f64]) -> Self {
        // Without a little noise, rounding would make smooth covariances indefinite.
        let process = Process { covariance: covariance.clone(), mean: Mean::Zero, noise: 1e-12 };
        let llt = gram(&process, &values(places)).llt(Side::Lower).unwrap();
        Self { factor: llt.L().to_owned() }
    }

    pub(crate) fn one(&self, numbers: &mut Numbers) -> Vec<f64> {
        let white = Mat::from_fn(self.factor.nrows(), 1, |_, _| numbers.normal());
        (&self.factor * white).col(0).iter().copied().collect()
    }
}

/// Evaluates a natural cubic spline through values at 0, 1, 2, ...
pub(crate) fn spline(values: &[f64], at: f64) -> f64 {
    let n = values.len();
    // Second derivatives, by elimination of a tridiagonal system.
    let (mut above, mut right) = (vec![0.0; n], vec![0.0; n]);
    for i in 1..n - 1 {
        let pivot = 4.0 - above[i - 1];
        above[i] = 1.0 / pivot;
        right[i] = (6.0 * (values[i - 1] - 2.0 * values[i] + values[i + 1]) - right[i - 1]) / pivot;
    }
    let mut second = vec![0.0; n];
    for i in (1..n - 1).rev() {
        second[i] = right[i] - above[i] * second[i + 1];
    }
    let i = (at as usize).min(n - 2);
    let (b, a) = (at - i as f64, 1.0 - (at - i as f64));
    let bend = (a.powi(3) - a) * second[i] + (b.powi(3) - b) * second[i + 1];
    a * values[i] + b * values[i + 1] + bend / 6.0
}
