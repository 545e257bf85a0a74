//! Chooses the covariance of a signal: the family that predicts the signal best, with its likeliest parameters (METHOD
//! §4).

use super::covariance::Covariance;
use super::faults::too_short;
use super::functional::Functional;
use super::grid::Sample;
use super::kriging::{Mean, Process, gram};
use super::repeated::least_distance;
use super::table::{Table, autocovariance};
use crate::Error;
use crate::numeric::columns::ends;
use faer::linalg::solvers::{DenseSolveCore, Llt};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Side};

/// Samples in a block, and samples at each end of a block that the left-out error does not count.
const BLOCK: usize = 96;
const END: usize = 2;
/// Lengths to try, in samples: the shortest, the ratio of neighbours, and their number.
const FIRST: f64 = 0.5;
const RATIO: f64 = 1.5;
const LENGTHS: usize = 10;
/// Most lengths below the usual ones, down to half the least distance.
const SHORT_LENGTHS: f64 = 12.0;
/// Refinement steps around the best length; each halves the ratio's logarithm.
const HALVINGS: usize = 4;
/// Ratio of neighbouring periods to try, and their number on each side of the spectrum's peak.
const PERIOD_RATIO: f64 = 1.03;
const PERIODS: i32 = 10;
/// Least conditional deviation of an observation given the earlier ones, relative to its own deviation.
const PIVOT: f64 = 1e-6;
/// Lags of an estimated covariance: at most this fraction of the samples, and at most this number.
const SHARE: usize = 4;
const LAGS: usize = 256;

/// Families that a kernel part can represent for values alone.
pub(super) const OF_VALUES: [&str; 4] =
    ["ornstein-uhlenbeck", "matern 3/2", "matern 5/2", "squared exponential"];

/// Default number of taps. More taps change images by less than 0.01 dB (*measured*).
pub const TAPS: usize = 7;

/// Returns the default covariance of images. On the rendered faces of `ict-views` this family is the best of those with
/// a length, for every length from 2 pixels on (*measured*).
pub const fn of_images() -> Covariance {
    Covariance::OrnsteinUhlenbeck { length: 3.0 }
}

/// Chooses the covariance of a signal; distances are in samples. Each family takes its likeliest parameters around a
/// constant mean. The family with the smallest left-out error within blocks wins. A constant signal gets the
/// Ornstein-Uhlenbeck covariance, since every family fits equally well.
///
/// The likelihood alone is not enough. Animation curves mostly rest, and their likeliest families are so rough that a
/// cubic spline is up to a fifth better (*measured*).
///
/// # Errors
/// If there are fewer than two samples.
pub fn best(samples: &[f64], sample: Sample) -> Result<Covariance, Error> {
    if samples.len() < 2 {
        return Err(too_short(samples.len(), 2));
    }
    let usual = Covariance::OrnsteinUhlenbeck { length: 3.0 };
    if samples.iter().all(|x| *x == samples[0]) {
        return Ok(usual);
    }
    let functionals = block(samples, sample);
    // Each family with the covariance to take if none of its covariances has a likelihood.
    let mut families: Vec<(Vec<(Ladder, Covariance)>, Covariance)> = Vec::new();
    for family in OF_VALUES.iter().filter_map(|name| Covariance::named(name, &[1.0])) {
        families.push((vec![(Ladder::of_samples(FIRST), family)], usual.clone()));
    }
    if let Some(period) = period(samples) {
        let of_period = |step: i32| {
            let period = period * PERIOD_RATIO.powi(step);
            let ladder = Ladder::of_samples(FIRST.max(0.5 * period));
            (ladder, Covariance::Oscillating { length: period, period })
        };
        let middle = Covariance::Oscillating { length: period, period };
        families.push(((-PERIODS..=PERIODS).map(of_period).collect(), middle));
    }
    let mut best = (f64::NEG_INFINITY, usual);
    for (family, otherwise) in families {
        let found = likeliest_of(0.0, (&functionals, samples), family, |_| true);
        let covariance = found.unwrap_or(otherwise);
        let block = Block::new(&functionals, &covariance, 0.0);
        let score = block.map_or(f64::NEG_INFINITY, |block| -block.left_out(samples));
        if score > best.0 {
            best = (score, covariance);
        }
    }
    Ok(best.1)
}

/// Geometric sequence of lengths to try.
#[derive(Clone, Copy, Debug)]
pub struct Ladder {
    first: f64,
    ratio: f64,
    len: usize,
    /// Rounds lengths so that the kernel's scale is a power of 2, by which f32 multiplies exactly.
    exact: bool,
}

impl Ladder {
    const fn of_samples(first: f64) -> Self {
        Self { first, ratio: RATIO, len: LENGTHS, exact: false }
    }

    /// Returns lengths around the mean distance of observations.
    pub fn usual(functionals: &[Functional]) -> Self {
        Self::of_samples(FIRST * unit(functionals))
    }

    /// Returns lengths from half the least distance of observations up to the usual lengths, for clusters that are far
    /// apart. `None` if the usual lengths start there.
    pub fn short(functionals: &[Functional]) -> Option<Self> {
        let first = FIRST * least_distance(functionals)?;
        let octaves = libm::log2(FIRST * unit(functionals) / first);
        let ratio = libm::exp2((octaves / SHORT_LENGTHS).ceil().max(1.0));
        let len = (octaves / libm::log2(ratio)).round();
        (len >= 1.0).then_some(Self { first, ratio, len: len as usize, exact: true })
    }

    /// Returns the sequence for a family; exact sequences depend on the family's kernel.
    fn of(self, family: &Covariance) -> Self {
        let one = family.with_length(1.0).kernel();
        let Some((_, factor)) = one.filter(|_| self.exact) else { return self };
        Self { first: factor / libm::exp2(libm::log2(factor / self.first).round()), ..self }
    }
}

/// Chooses the likeliest covariance of observations among families, each with the lengths to try; the length of a
/// given covariance does not matter. Scattered observations are too few, in too many units, for a left-out error.
/// `None` if no covariance is accepted.
///
/// - `noise`: τ.
/// - `sound`: accepts or rejects a covariance, for example if its function cannot be solved for.
pub fn likeliest_of(
    noise: f64,
    (functionals, values): (&[Functional], &[f64]),
    families: impl IntoIterator<Item = (Ladder, Covariance)>,
    mut sound: impl FnMut(&Covariance) -> bool,
) -> Option<Covariance> {
    let mut best: Option<(f64, Covariance)> = None;
    for (ladder, family) in families {
        refine(ladder.of(&family), |length| {
            let covariance = family.with_length(length);
            let block = Block::new(functionals, &covariance, noise);
            let score = block.map_or(f64::NEG_INFINITY, |block| block.likelihood(values));
            let beats = best.as_ref().is_none_or(|(best, _)| score > *best);
            if beats && score > f64::NEG_INFINITY {
                if !sound(&covariance) {
                    return f64::NEG_INFINITY;
                }
                best = Some((score, covariance));
            }
            score
        });
    }
    best.map(|(_, covariance)| covariance)
}

/// Returns the mean distance between neighbouring observations; 1 if all are at one place.
pub fn unit(functionals: &[Functional]) -> f64 {
    let places: Vec<f64> = functionals.iter().map(Functional::middle).collect();
    let [low, high] = ends(&places);
    let spacing = (high - low) / (places.len().max(2) - 1) as f64;
    if spacing > 0.0 { spacing } else { 1.0 }
}

/// Estimates the likeliest variance of a signal's process; 0 if rounding makes the covariance singular.
pub fn variance(samples: &[f64], sample: Sample, covariance: &Covariance) -> f64 {
    let block = Block::new(&block(samples, sample), covariance, 0.0);
    block.map_or(0.0, |block| block.variance(samples))
}

/// Estimates a covariance as a table, by the biased estimator; distances are in samples. Also returns the clipped share
/// of the spectrum.
///
/// # Errors
/// Errors of [`Table::new`].
pub fn estimated(samples: &[f64]) -> Result<(Covariance, f64), Error> {
    let lags = (samples.len() / SHARE).clamp(2, LAGS);
    let (table, clipped) = Table::new(&autocovariance(samples, lags), 1.0)?;
    Ok((Covariance::Table(table), clipped))
}

/// Lists the functionals that the samples of the first block observe.
fn block(samples: &[f64], sample: Sample) -> Vec<Functional> {
    (0..samples.len().min(BLOCK)).map(|i| sample.functional(i, 0, 1)).collect()
}

/// Evaluates a function of length along the sequence, then in shrinking steps around its maximum.
fn refine(Ladder { first, ratio, len, .. }: Ladder, mut of: impl FnMut(f64) -> f64) {
    let mut best = (f64::NEG_INFINITY, first);
    for step in 0..len {
        let length = first * ratio.powi(step as i32);
        let found = of(length);
        best = if found > best.0 { (found, length) } else { best };
    }
    let mut ratio = ratio.sqrt();
    for _ in 0..HALVINGS {
        for length in [best.1 / ratio, best.1 * ratio] {
            let found = of(length);
            best = if found > best.0 { (found, length) } else { best };
        }
        ratio = ratio.sqrt();
    }
}

/// Factored covariance matrix of a block of observations.
struct Block {
    llt: Llt<f64>,
    /// Whitened basis of the constant mean, m x 1: 1 for values and averages, 0 for derivatives.
    ones: Mat<f64>,
}

impl Block {
    /// Factors the covariance matrix of observations; `None` if rounding makes the matrix singular.
    fn new(functionals: &[Functional], covariance: &Covariance, noise: f64) -> Option<Self> {
        let process = Process { covariance: covariance.clone(), mean: Mean::Constant, noise };
        let matrix = gram(&process, functionals);
        let llt = matrix.llt(Side::Lower).ok()?;
        // Each pivot has the unit of its observation. NaN fails the comparison.
        let is_open = |i: usize| llt.L()[(i, i)] >= PIVOT * matrix[(i, i)].sqrt();
        if !(0..functionals.len()).all(is_open) {
            return None;
        }
        let one = |i: usize, _| process.mean.terms(&functionals[i], [0.0, 1.0])[0];
        let ones = Mat::from_fn(functionals.len(), 1, one);
        let ones = whitened(&llt, ones);
        Some(Self { llt, ones })
    }

    /// Computes the logarithm of a signal's likelihood over all blocks, at the likeliest mean and variance.
    fn likelihood(&self, samples: &[f64]) -> f64 {
        let pivots = self.llt.L().diagonal().column_vector().iter();
        let determinant: f64 = pivots.map(|pivot| libm::log(*pivot)).sum();
        let len = self.ones.nrows();
        let blocks = (samples.len() / len) as f64;
        -blocks * (0.5 * len as f64 * libm::log(self.variance(samples)) + determinant)
    }

    /// Computes the likeliest variance of a signal; an incomplete last block is left out.
    fn variance(&self, samples: &[f64]) -> f64 {
        let len = self.ones.nrows();
        let blocks = whitened(&self.llt, columns(samples, len));
        let all = self.ones.squared_norm_l2() * blocks.ncols() as f64;
        let sum: f64 = blocks.col_iter().map(|block| self.ones.col(0).transpose() * block).sum();
        let mean = if all > 0.0 { sum / all } else { 0.0 };
        let rest = blocks
            .col_iter()
            .map(|block| (block - self.ones.col(0) * faer::Scale(mean)).squared_norm_l2());
        rest.sum::<f64>() / (len * blocks.ncols()) as f64
    }

    /// Computes the mean square left-out error: each sample is predicted from the others of its block. With P = K⁻¹ -
    /// K⁻¹1 1ᵀK⁻¹/1ᵀK⁻¹1, the error of sample i is (P y)_i / P_ii.
    fn left_out(&self, samples: &[f64]) -> f64 {
        let len = self.ones.nrows();
        let inverse = self.llt.inverse();
        let ones = &inverse * Mat::<f64>::full(len, 1, 1.0);
        let all: f64 = ones.col(0).iter().sum();
        let p = &inverse - &ones * ones.transpose() * faer::Scale(1.0 / all);
        let missed = &p * columns(samples, len);
        let end = if len > 4 * END { END } else { 0 };
        let inside = end..len - end;
        let square = |i: usize| missed.row(i).iter().map(|x| (x / p[(i, i)]).powi(2)).sum::<f64>();
        inside.clone().map(square).sum::<f64>() / (inside.len() * missed.ncols()) as f64
    }
}

/// Cuts a signal into columns of `len` samples.
fn columns(samples: &[f64], len: usize) -> Mat<f64> {
    Mat::from_fn(len, samples.len() / len, |i, b| samples[b * len + i])
}

fn whitened(llt: &Llt<f64>, mut of: Mat<f64>) -> Mat<f64> {
    solve_lower_triangular_in_place(llt.L(), of.as_mut(), Par::Seq);
    of
}

/// Finds the strongest period of a signal, in samples; `None` if the signal is too short.
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
    use super::super::kriging::Kriging;
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Draws samples of a process with mean 5 and deviation 2.
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
        let found = best(&drawn(&ou, 480, 1), Sample::Value).unwrap();
        assert!(matches!(found, Covariance::OrnsteinUhlenbeck { .. }), "{found:?}");
        let oscillating = Covariance::Oscillating { length: 4.0, period: 2.6 };
        let found = best(&drawn(&oscillating, 288, 2), Sample::Value).unwrap();
        let Covariance::Oscillating { length, period } = found else { panic!("{found:?}") };
        assert!(
            (2.5..6.5).contains(&length) && (2.45..2.75).contains(&period),
            "{length} {period}"
        );
    }

    #[test]
    fn left_out_errors_match_separate_fits() {
        let covariance = Covariance::Matern32 { length: 1.7 };
        let samples = drawn(&covariance, 7, 3);
        let functionals = block(&samples, Sample::Value);
        let found = Block::new(&functionals, &covariance, 0.0).unwrap().left_out(&samples);
        let process = Process { covariance, mean: Mean::Constant, noise: 0.0 };
        let missed = (0..7).map(|i| {
            let others: Vec<usize> = (0..7).filter(|k| *k != i).collect();
            let at: Vec<_> = others.iter().map(|k| functionals[*k]).collect();
            let values: Vec<f64> = others.iter().map(|k| samples[*k]).collect();
            let fit = Kriging::new(&process, &at, &values).unwrap();
            (fit.predict(&functionals[i]).value - samples[i]).powi(2)
        });
        let expected = missed.sum::<f64>() / 7.0;
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    }

    #[test]
    fn a_constant_has_a_covariance_and_one_sample_has_none() {
        assert!(best(&[3.0; 20], Sample::Value).is_ok());
        let short = best(&[3.0], Sample::Value).unwrap_err();
        assert_eq!(short.to_string(), "1 samples are fewer than a window's 2: take fewer taps");
    }
}
