//! HyperBF: sums of few kernels whose centres and metric are learned (S1 appendix 1, METHOD §3).
//!
//! [`learn()`] places centres on samples ([`Start`]) and moves the centres and the metric by one of three methods
//! ([`Method`]). It starts once from every seed and keeps the best result. The methods lower the energy.
//!
//! The same seed gives the same trace, bit for bit, on any CPU. Random numbers are ChaCha8's, loops are scalar with a
//! fixed order, and libm computes everything except sums, products, quotients and square roots.

mod energy;
mod least_squares;
mod methods;
mod options;

pub use options::{Entries, Method, Metric, Options, Start, Step, Trace};

use crate::Error;
use crate::regression::function::order;
use crate::scattered::sum::{KernelSum, monomials, squared};
use energy::{Energy, Parameters, Point};
use faer::{Mat, MatRef};
use options::wrong_number;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Learned function.
#[derive(Clone, Debug)]
pub struct Learned {
    /// Sum of kernels with the least energy.
    pub sum: KernelSum,
    /// Energy of the sum.
    pub energy: f64,
    /// Index of the trace that led to the sum.
    pub best: usize,
    /// Trace of each seed, in the order of the seeds.
    pub traces: Vec<Trace>,
}

/// Learns a function from sites x (N x d) and values y (N x m).
///
/// - `shift`, `scale`: d each, turn x into u, the coordinates of centres, metric and polynomial.
///
/// # Errors
/// - If there are no samples, inputs or values, or a length does not match the samples.
/// - If the ridge is negative or not finite.
/// - If the kernel is a hat.
/// - If there are no centres or no seeds.
/// - If there are more centres and monomials than samples.
/// - If a number of the method is out of its range.
/// - If a start's energy is not finite.
pub fn learn(
    sites: MatRef<'_, f64>,
    values: MatRef<'_, f64>,
    shift: &[f64],
    scale: &[f64],
    options: &Options,
) -> Result<Learned, Error> {
    let energy = Energy::new(sites, values, shift, scale, options)?;
    check(&energy, options)?;
    let from = |&seed: &u64| from_seed(&energy, options, seed);
    let learned: Vec<_> = options.seeds.par_iter().map(from).collect();
    let learned = learned.into_iter().collect::<Result<Vec<_>, _>>()?;
    let (points, traces): (Vec<_>, Vec<_>) = learned.into_iter().unzip();
    let best = points.into_iter().enumerate().min_by(|a, b| a.1.energy.total_cmp(&b.1.energy));
    let (best, Point { parameters, energy: least, .. }) =
        best.ok_or_else(|| Error::missing("there is no seed"))?;
    let sum = sum(&energy, &parameters, shift, scale, options);
    Ok(Learned { sum, energy: least, best, traces })
}

fn check(energy: &Energy, options: &Options) -> Result<(), Error> {
    if order(options.kernel).is_none() {
        return Err(Error::unsupported(
            "nothing can be learned with a hat: it is for evaluation alone",
        ));
    }
    let (centres, terms, samples) = (options.centres, energy.term_len(), energy.sample_len);
    if centres == 0 {
        return Err(Error::value("the number of centres is 0"));
    }
    if centres.saturating_add(terms) > samples {
        return Err(Error::fit(format!(
            "{centres} centres and a polynomial of {terms} terms need as many samples, found {samples}"
        )));
    }
    let numbers = match options.method {
        Method::VariableProjection => Vec::new(),
        Method::GradientFlow { step } => vec![("ω", step)],
        Method::Metropolis { reach, temperatures: [first, last] } => {
            vec![("the reach", reach), ("the first T", first), ("the last T", last)]
        }
    };
    for (name, found) in numbers {
        if !(found >= 0.0 && found.is_finite()) {
            return Err(wrong_number(name, found));
        }
    }
    Ok(())
}

fn from_seed(energy: &Energy, options: &Options, seed: u64) -> Result<(Point, Trace), Error> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let rows = options.metric.start.row_iter();
    let metric: Vec<f64> = rows.flat_map(|row| row.iter().copied()).collect();
    let samples = choose_samples(options.start, energy, &metric, options.centres, &mut random);
    let start = energy.solved(centres_on(energy, &metric, &samples));
    if !start.energy.is_finite() {
        return Err(Error::value(format!(
            "the energy is not finite where seed {seed} starts: a sample or the metric is not"
        )));
    }
    let mut trace = Trace { seed, start: start.energy, steps: Vec::new(), evaluations: 1 };
    let budget = options.evaluations;
    let point = match options.method {
        Method::VariableProjection => {
            methods::variable_projection(energy, start, budget, &mut trace)
        }
        Method::GradientFlow { step } => {
            methods::gradient_flow(energy, start, step, budget, &mut trace)
        }
        Method::Metropolis { reach, temperatures } => {
            methods::Walk { energy, reach, temperatures, budget }.run(
                start,
                &mut random,
                &mut trace,
            )
        }
    };
    Ok((point, trace))
}

/// Makes the sum with given parameters. Its centres are products with the metric.
fn sum(
    energy: &Energy,
    parameters: &Parameters,
    shift: &[f64],
    scale: &[f64],
    options: &Options,
) -> KernelSum {
    let (rows, inputs) = (options.metric.start.nrows(), options.metric.start.ncols());
    let centres = energy.measured(&parameters.metric, &parameters.centres);
    let metric = Mat::from_fn(rows, inputs, |r, i| parameters.metric[r * inputs + i]);
    let count = options.centres + energy.term_len();
    let coefficient = |o: usize, k: usize| parameters.coefficients[o * count + k];
    KernelSum {
        kernel: options.kernel,
        shift: shift.to_vec(),
        scale: scale.to_vec(),
        centres: Mat::from_fn(rows, options.centres, |r, a| centres[a * rows + r]),
        metric: (metric != Mat::<f64>::identity(inputs, inputs)).then_some(metric),
        terms: options.degree.map_or_else(Vec::new, |degree| monomials(inputs, degree)),
        coefficients: Mat::from_fn(energy.value_len(), count, coefficient),
    }
}

/// Chooses `count` different samples.
///
/// - `metric`: W by rows, for distances between samples.
fn choose_samples(
    start: Start,
    energy: &Energy,
    metric: &[f64],
    count: usize,
    random: &mut ChaCha8Rng,
) -> Vec<usize> {
    match start {
        Start::Random => random_samples(energy.sample_len, count, random),
        Start::KMeansPlusPlus => k_means_plus_plus(energy, metric, count, random),
    }
}

/// Draws samples with equal probability.
fn random_samples(sample_len: usize, count: usize, random: &mut ChaCha8Rng) -> Vec<usize> {
    let mut samples: Vec<usize> = (0..sample_len).collect();
    for place in 0..count {
        samples.swap(place, random.random_range(place..sample_len));
    }
    samples.truncate(count);
    samples
}

/// Draws each sample with a probability proportional to its squared distance from the earlier ones. If all distances
/// are 0, the next sample is any other sample.
fn k_means_plus_plus(
    energy: &Energy,
    metric: &[f64],
    count: usize,
    random: &mut ChaCha8Rng,
) -> Vec<usize> {
    let measured = energy.measured(metric, &energy.inputs);
    let row_len = measured.len() / energy.sample_len;
    let at = |sample: usize| &measured[sample * row_len..][..row_len];
    let mut chosen = vec![random.random_range(0..energy.sample_len)];
    let mut distances = vec![f64::INFINITY; energy.sample_len];
    while chosen.len() < count {
        let last = chosen[chosen.len() - 1];
        for (i, distance) in distances.iter_mut().enumerate() {
            *distance = distance.min(squared(at(i), at(last).iter()));
        }
        let mut left = random.random::<f64>() * distances.iter().sum::<f64>();
        let drawn = distances.iter().position(|distance| {
            left -= distance;
            left < 0.0
        });
        let next = drawn.or_else(|| (0..energy.sample_len).find(|i| !chosen.contains(i)));
        chosen.extend(next);
    }
    chosen
}

/// Places centres on samples, without coefficients.
fn centres_on(energy: &Energy, metric: &[f64], samples: &[usize]) -> Parameters {
    let centres = samples.iter().flat_map(|&i| energy.input(i).iter().copied()).collect();
    Parameters { centres, metric: metric.to_vec(), coefficients: Vec::new() }
}
