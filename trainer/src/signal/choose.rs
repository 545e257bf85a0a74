//! The covariance under which a signal is likeliest (METHOD §4).

use super::covariance::Covariance;
use super::error::SignalError;
use super::functional::Functional;
use super::grid::Sample;
use super::kriging::{Process, gram};
use super::mean::Mean;
use super::table::{Estimator, Table, autocovariance};
use crate::numeric::columns::ends;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Side};

/// Samples of a block: the likelihood of a signal is the product of those of its blocks.
const BLOCK: usize = 96;
/// Lengths that are tried first, in samples, each so many times the one before.
const FIRST: f64 = 0.5;
const RATIO: f64 = 1.5;
const LENGTHS: usize = 10;
/// Halvings of the step between lengths about the best.
const HALVINGS: usize = 4;
/// Periods that a period of a signal is looked for among, each so many times the one before.
const PERIOD_RATIO: f64 = 1.08;
/// Least share of the largest pivot that a system's least one has.
const PIVOT: f64 = 1e-6;
/// Largest share of its samples up to which the covariance of a signal is estimated, and most lags.
const SHARE: usize = 4;
const LAGS: usize = 256;

/// Taps of a window where none are asked for: more change images by less than 0.01 dB (*measured*).
pub const TAPS: usize = 7;

/// Returns the covariance that images have where none is asked for: on the rendered faces of `ict-views` it is the best
/// of the families with a length, whatever that is from 2 pixels on (*measured*).
pub const fn of_images() -> Covariance {
    Covariance::OrnsteinUhlenbeck { length: 3.0 }
}

/// Chooses a family and its numbers by the likelihood of a signal's samples about a constant; distances are in
/// samples. A constant signal is as likely under all: it has Ornstein's and Uhlenbeck's.
///
/// # Errors
/// [`SignalError::TooShort`] of fewer samples than two.
pub fn likeliest(samples: &[f64], sample: Sample) -> Result<Covariance, SignalError> {
    if samples.len() < 2 {
        return Err(SignalError::TooShort { found: samples.len(), least: 2 });
    }
    let mut best = Best::new(Covariance::OrnsteinUhlenbeck { length: 3.0 });
    if samples.iter().all(|x| *x == samples[0]) {
        return Ok(best.covariance);
    }
    let functionals = block(samples, sample);
    let mut offer = |covariance: Covariance| {
        let found = likelihood(&functionals, samples, &covariance).0;
        best.offer(found, covariance)
    };
    for name in ["ornstein-uhlenbeck", "matern 3/2", "matern 5/2", "squared exponential"] {
        refine(FIRST, named(name, &mut offer));
    }
    if let Some(period) = period(samples) {
        let mut own = (f64::NEG_INFINITY, period);
        for step in -6..=6 {
            let period = period * PERIOD_RATIO.powi(step);
            let of = |length| offer(Covariance::Oscillating { length, period });
            let found = refine(FIRST.max(0.5 * period), of);
            own = if found > own.0 { (found, period) } else { own };
        }
        for step in [-0.5, -0.25, 0.25, 0.5] {
            let period = own.1 * PERIOD_RATIO.powf(step);
            let of = |length| offer(Covariance::Oscillating { length, period });
            refine(FIRST.max(0.5 * period), of);
        }
    }
    Ok(best.covariance)
}

/// Chooses likewise among families of these names for values of functionals anywhere.
pub fn likeliest_of(functionals: &[Functional], values: &[f64], names: &[&str]) -> Covariance {
    let places: Vec<f64> = functionals.iter().map(Functional::middle).collect();
    let [low, high] = ends(&places);
    let spacing = (high - low) / (places.len().max(2) - 1) as f64;
    let unit = if spacing > 0.0 { spacing } else { 1.0 };
    let mut best = Best::new(Covariance::SquaredExponential { length: unit });
    for name in names {
        let mut offer = |covariance: Covariance| {
            let found = likelihood(functionals, values, &covariance).0;
            best.offer(found, covariance)
        };
        refine(FIRST * unit, named(name, &mut offer));
    }
    best.covariance
}

/// Estimates the variance of a signal's process, likewise.
pub fn variance(samples: &[f64], sample: Sample, covariance: &Covariance) -> f64 {
    likelihood(&block(samples, sample), samples, covariance).1
}

/// Estimates a covariance as a table, by the biased estimator; distances are in samples. Also returns the share of its
/// spectrum that had to be clipped.
///
/// # Errors
/// Those of [`Table::new`].
pub fn estimated(samples: &[f64]) -> Result<(Covariance, f64), SignalError> {
    let lags = (samples.len() / SHARE).clamp(2, LAGS);
    let (table, clipped) = Table::new(&autocovariance(samples, lags, Estimator::Biased), 1.0)?;
    Ok((Covariance::Table(table), clipped))
}

/// The covariance of the greatest likelihood that was offered.
struct Best {
    likelihood: f64,
    covariance: Covariance,
}

impl Best {
    fn new(covariance: Covariance) -> Self {
        Self { likelihood: f64::NEG_INFINITY, covariance }
    }

    fn offer(&mut self, likelihood: f64, covariance: Covariance) -> f64 {
        if likelihood > self.likelihood {
            (self.likelihood, self.covariance) = (likelihood, covariance);
        }
        likelihood
    }
}

/// Offers a family's covariances by their length.
fn named(name: &str, mut offer: impl FnMut(Covariance) -> f64) -> impl FnMut(f64) -> f64 {
    move |length| Covariance::named(name, &[length]).map_or(f64::NEG_INFINITY, &mut offer)
}

/// Lists what the samples of a block observe.
fn block(samples: &[f64], sample: Sample) -> Vec<Functional> {
    (0..samples.len().min(BLOCK)).map(|i| sample.functional(i, 0, 1)).collect()
}

/// Tries lengths on a ladder, then about the best; returns the best that was found.
fn refine(first: f64, mut of: impl FnMut(f64) -> f64) -> f64 {
    let mut best = (f64::NEG_INFINITY, first);
    for step in 0..LENGTHS {
        let length = first * RATIO.powi(step as i32);
        let found = of(length);
        best = if found > best.0 { (found, length) } else { best };
    }
    let mut ratio = RATIO.sqrt();
    for _ in 0..HALVINGS {
        for length in [best.1 / ratio, best.1 * ratio] {
            let found = of(length);
            best = if found > best.0 { (found, length) } else { best };
        }
        ratio = ratio.sqrt();
    }
    best.0
}

/// Computes the logarithm of a signal's likelihood, block by block, and its variance, its mean and variance the
/// likeliest; minus infinity of a covariance that rounding makes singular.
fn likelihood(functionals: &[Functional], samples: &[f64], covariance: &Covariance) -> (f64, f64) {
    const NONE: (f64, f64) = (f64::NEG_INFINITY, 0.0);
    let len = functionals.len();
    let process = Process { covariance: covariance.clone(), mean: Mean::Constant, noise: 0.0 };
    let Ok(llt) = gram(&process, functionals).llt(Side::Lower) else { return NONE };
    let pivots: Vec<f64> = llt.L().diagonal().column_vector().iter().copied().collect();
    let greatest = pivots.iter().copied().fold(0.0, f64::max);
    if pivots.iter().any(|pivot| pivot.is_nan() || *pivot < PIVOT * greatest) {
        return NONE;
    }
    let ones: Vec<f64> =
        functionals.iter().map(|of| process.mean.terms(of, [0.0, 1.0])[0]).collect();
    // What is left over at the end is left out, but for a signal of one block.
    let blocks: Vec<&[f64]> = samples.chunks_exact(len).collect();
    let number = |i: usize, b: usize| blocks.get(b).map_or(ones[i], |block| block[i]);
    let mut columns = Mat::from_fn(len, blocks.len() + 1, number);
    solve_lower_triangular_in_place(llt.L(), columns.as_mut(), Par::Seq);
    let ones = columns.col(blocks.len());
    let all = ones.squared_norm_l2() * blocks.len() as f64;
    let sum: f64 = (0..blocks.len()).map(|b| ones.transpose() * columns.col(b)).sum();
    let mean = if all > 0.0 { sum / all } else { 0.0 };
    let rest = |b: usize| (columns.col(b) - ones * faer::Scale(mean)).squared_norm_l2();
    let n = (len * blocks.len()) as f64;
    let variance = (0..blocks.len()).map(rest).sum::<f64>() / n;
    let determinant = pivots.iter().map(|pivot| libm::log(*pivot)).sum::<f64>();
    (-0.5 * n * libm::log(variance) - determinant * blocks.len() as f64, variance)
}

/// Finds the period, in samples, at which a signal swings most; none of one that is too short.
fn period(samples: &[f64]) -> Option<f64> {
    let n = samples.len().min(16 * BLOCK);
    let samples = &samples[..n];
    let mean = samples.iter().sum::<f64>() / n as f64;
    let power = |k: usize| {
        let [mut real, mut imaginary] = [0.0; 2];
        for (i, x) in samples.iter().enumerate() {
            let angle = std::f64::consts::TAU * (i * k % n) as f64 / n as f64;
            real += (x - mean) * libm::cos(angle);
            imaginary += (x - mean) * libm::sin(angle);
        }
        real * real + imaginary * imaginary
    };
    let powers = (2..n / 2).map(|k| (power(k), k));
    powers.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, k)| n as f64 / k as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A sample of a process.
    fn drawn(covariance: &Covariance, n: usize, seed: u64) -> Vec<f64> {
        let process = Process { covariance: covariance.clone(), mean: Mean::Zero, noise: 1e-9 };
        let at: Vec<_> = (0..n).map(|i| Sample::Value.functional(i, 0, 1)).collect();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut uniform = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        let white = Mat::from_fn(n, 1, |_, _| (0..12).map(|_| uniform()).sum::<f64>() - 6.0);
        let factor = gram(&process, &at).llt(Side::Lower).unwrap();
        (factor.L() * white).col(0).iter().map(|x| 5.0 + 2.0 * x).collect()
    }

    #[test]
    fn the_family_of_a_process_is_found_again() {
        let ou = Covariance::OrnsteinUhlenbeck { length: 6.0 };
        let found = likeliest(&drawn(&ou, 480, 1), Sample::Value).unwrap();
        let Covariance::OrnsteinUhlenbeck { length } = found else { panic!("{found:?}") };
        assert!((3.0..12.0).contains(&length), "{length}");
        let oscillating = Covariance::Oscillating { length: 4.0, period: 2.6 };
        let found = likeliest(&drawn(&oscillating, 288, 2), Sample::Value).unwrap();
        let Covariance::Oscillating { length, period } = found else { panic!("{found:?}") };
        assert!((3.0..5.5).contains(&length) && (2.5..2.7).contains(&period), "{length} {period}");
    }

    #[test]
    fn a_constant_has_a_covariance_and_one_sample_has_none() {
        assert!(likeliest(&[3.0; 20], Sample::Value).is_ok());
        let short = likeliest(&[3.0], Sample::Value);
        assert!(matches!(short, Err(SignalError::TooShort { .. })));
    }
}
