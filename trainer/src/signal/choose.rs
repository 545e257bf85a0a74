//! Chooses the covariance of a signal: the family that predicts the signal best, with its likeliest parameters (METHOD
//! §4).

use super::covariance::Covariance;
use super::faults::too_short;
use super::functional::Functional;
use super::grid::Sample;
use super::kriging::{Mean, Process, gram};
use super::repeated::least_distance;
use super::table::{Estimator, Table, autocovariance};
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
    let mut best = Best::new(Covariance::OrnsteinUhlenbeck { length: 3.0 });
    if samples.iter().all(|x| *x == samples[0]) {
        return Ok(best.covariance);
    }
    let functionals = block(samples, sample);
    let mut families: Vec<Best> = Vec::new();
    for name in ["ornstein-uhlenbeck", "matern 3/2", "matern 5/2", "squared exponential"] {
        let mut own = Best::new(Covariance::OrnsteinUhlenbeck { length: 3.0 });
        refine(
            Ladder::of_samples(FIRST),
            named(name, |covariance| own.offer_likely(&functionals, samples, covariance)),
        );
        families.push(own);
    }
    if let Some(period) = period(samples) {
        let mut own = Best::new(Covariance::Oscillating { length: period, period });
        for step in -PERIODS..=PERIODS {
            let period = period * PERIOD_RATIO.powi(step);
            refine(Ladder::of_samples(FIRST.max(0.5 * period)), |length| {
                let covariance = Covariance::Oscillating { length, period };
                own.offer_likely(&functionals, samples, covariance)
            });
        }
        families.push(own);
    }
    for Best { covariance, .. } in families {
        let found = Block::new(&functionals, &covariance).map(|block| -block.left_out(samples));
        best.offer(found, covariance);
    }
    Ok(best.covariance)
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
    fn of(self, name: &str) -> Self {
        let one = Covariance::named(name, &[1.0]).and_then(|one| one.kernel());
        let Some((_, factor)) = one.filter(|_| self.exact) else { return self };
        Self { first: factor / libm::exp2(libm::log2(factor / self.first).round()), ..self }
    }
}

/// Chooses the likeliest covariance of scattered observations among named families. There are too few observations, in
/// too many units, for a left-out error. `None` if no covariance is accepted.
///
/// - `noise`: τ.
/// - `sound`: accepts or rejects a covariance, for example if its function cannot be solved for.
pub fn likeliest_of(
    noise: f64,
    (functionals, values): (&[Functional], &[f64]),
    names: &[&str],
    ladder: Ladder,
    mut sound: impl FnMut(&Covariance) -> bool,
) -> Option<Covariance> {
    let mut best: Option<(f64, Covariance)> = None;
    for name in names {
        let offer = |covariance: Covariance| {
            let found = Block::with_noise(functionals, &covariance, noise);
            let found = found.map(|block| block.likelihood(values));
            let score = found.unwrap_or(f64::NEG_INFINITY);
            let beats = best.as_ref().is_none_or(|(best, _)| score > *best);
            if beats && score > f64::NEG_INFINITY {
                if !sound(&covariance) {
                    return f64::NEG_INFINITY;
                }
                best = Some((score, covariance));
            }
            score
        };
        refine(ladder.of(name), named(name, offer));
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
    let block = Block::new(&block(samples, sample), covariance);
    block.map_or(0.0, |block| block.variance(samples))
}

/// Estimates a covariance as a table, by the biased estimator; distances are in samples. Also returns the clipped share
/// of the spectrum.
///
/// # Errors
/// Errors of [`Table::new`].
pub fn estimated(samples: &[f64]) -> Result<(Covariance, f64), Error> {
    let lags = (samples.len() / SHARE).clamp(2, LAGS);
    let (table, clipped) = Table::new(&autocovariance(samples, lags, Estimator::Biased), 1.0)?;
    Ok((Covariance::Table(table), clipped))
}

/// The covariance with the largest score so far.
struct Best {
    score: f64,
    covariance: Covariance,
}

impl Best {
    fn new(covariance: Covariance) -> Self {
        Self { score: f64::NEG_INFINITY, covariance }
    }

    /// Scores a covariance by its likelihood.
    fn offer_likely(&mut self, of: &[Functional], values: &[f64], covariance: Covariance) -> f64 {
        let found = Block::new(of, &covariance).map(|block| block.likelihood(values));
        self.offer(found, covariance)
    }

    /// Keeps the covariance if its score is the largest so far. Returns the score; minus infinity for `None`.
    fn offer(&mut self, score: Option<f64>, covariance: Covariance) -> f64 {
        let score = score.unwrap_or(f64::NEG_INFINITY);
        if score > self.score {
            (self.score, self.covariance) = (score, covariance);
        }
        score
    }
}

/// Turns a function of covariances into a function of one family's length.
fn named(name: &str, mut offer: impl FnMut(Covariance) -> f64) -> impl FnMut(f64) -> f64 {
    move |length| Covariance::named(name, &[length]).map_or(f64::NEG_INFINITY, &mut offer)
}

/// Lists the functionals that the samples of the first block observe.
fn block(samples: &[f64], sample: Sample) -> Vec<Functional> {
    (0..samples.len().min(BLOCK)).map(|i| sample.functional(i, 0, 1)).collect()
}

/// Maximises a function of length: along the sequence, then in shrinking steps around the best. Returns the maximum.
fn refine(Ladder { first, ratio, len, .. }: Ladder, mut of: impl FnMut(f64) -> f64) -> f64 {
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
    best.0
}

/// Factored covariance matrix of a block of observations.
struct Block {
    llt: Llt<f64>,
    /// Whitened basis of the constant mean, m x 1: 1 for values and averages, 0 for derivatives.
    ones: Mat<f64>,
}

impl Block {
    /// Factors the covariance matrix of observations; `None` if rounding makes the matrix singular.
    fn new(functionals: &[Functional], covariance: &Covariance) -> Option<Self> {
        Self::with_noise(functionals, covariance, 0.0)
    }

    /// Factors the covariance matrix of noisy observations; `None` if rounding makes the matrix singular.
    fn with_noise(functionals: &[Functional], covariance: &Covariance, noise: f64) -> Option<Self> {
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
        let found = Block::new(&functionals, &covariance).unwrap().left_out(&samples);
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
