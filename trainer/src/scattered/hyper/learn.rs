//! From samples and options to a sum of kernels and how it was found.

use super::energy::{Energy, Parameters, Point};
use super::error::HyperError;
use super::metropolis::Walk;
use super::options::{Method, Options};
use super::start::{choose, placed};
use super::trace::{Stop, Trace};
use super::{flow, projection};
use crate::regression::function::order;
use crate::scattered::sum::{KernelSum, monomials};
use faer::{Mat, MatRef};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// What was learned.
#[derive(Clone, Debug)]
pub struct Learned {
    /// The function.
    pub sum: KernelSum,
    /// Its energy.
    pub energy: f64,
    /// The trace that led to it.
    pub best: usize,
    /// A trace a seed, in the seeds' order.
    pub traces: Vec<Trace>,
}

/// Learns a function from sites x (N x d) and values y (N x m); `shift` and `scale` (d each) turn x to
/// the u in which centres, metric and polynomial are.
///
/// # Errors
/// [`HyperError`] where [`Energy::new`] refuses, with a hat, where no centre or seed is asked for, where
/// centres and monomials are more than samples, where a number of the method is out of its range, and
/// where a start's energy is not finite.
pub fn learn(
    sites: MatRef<'_, f64>,
    values: MatRef<'_, f64>,
    shift: &[f64],
    scale: &[f64],
    options: &Options,
) -> Result<Learned, HyperError> {
    let energy = Energy::new(sites, values, shift, scale, options)?;
    check(&energy, options)?;
    let from = |&seed: &u64| from_seed(&energy, options, seed);
    let learned: Vec<_> = options.seeds.par_iter().map(from).collect();
    let learned = learned.into_iter().collect::<Result<Vec<_>, _>>()?;
    let (points, traces): (Vec<_>, Vec<_>) = learned.into_iter().unzip();
    let best = points.into_iter().enumerate().min_by(|a, b| a.1.energy.total_cmp(&b.1.energy));
    let (best, Point { parameters, energy: least, .. }) = best.ok_or(HyperError::NoSeeds)?;
    let sum = sum(&energy, &parameters, shift, scale, options);
    Ok(Learned { sum, energy: least, best, traces })
}

fn check(energy: &Energy, options: &Options) -> Result<(), HyperError> {
    if order(options.kernel).is_none() {
        return Err(HyperError::Hat);
    }
    let (centres, terms, samples) = (options.centres, energy.term_len(), energy.sample_len());
    if centres == 0 {
        return Err(HyperError::NoCentres);
    }
    if centres.saturating_add(terms) > samples {
        return Err(HyperError::TooFewSamples { centres, terms, samples });
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
            return Err(HyperError::Number { name, found });
        }
    }
    Ok(())
}

fn from_seed(energy: &Energy, options: &Options, seed: u64) -> Result<(Point, Trace), HyperError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let rows = options.metric.start.row_iter();
    let metric: Vec<f64> = rows.flat_map(|row| row.iter().copied()).collect();
    let samples = choose(options.start, energy, &metric, options.centres, &mut random);
    let start = energy.solved(placed(energy, &metric, &samples));
    if !start.energy.is_finite() {
        return Err(HyperError::NotFinite { seed });
    }
    let mut trace =
        Trace { seed, start: start.energy, steps: Vec::new(), evaluations: 1, stop: Stop::Budget };
    let budget = options.evaluations;
    let point = match options.method {
        Method::VariableProjection => projection::learn(energy, start, budget, &mut trace),
        Method::GradientFlow { step } => flow::learn(energy, start, step, budget, &mut trace),
        Method::Metropolis { reach, temperatures } => {
            Walk { energy, reach, temperatures, budget }.run(start, &mut random, &mut trace)
        }
    };
    Ok((point, trace))
}

/// Makes the function that parameters are; its centres are those that the metric sees.
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
