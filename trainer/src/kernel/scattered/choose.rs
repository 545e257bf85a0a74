//! Width and smoothing, chosen by leaving samples out (METHOD §2.2).

use super::error::KernelError;
use super::fit::Fit;
use super::matrix::{distances, gram};
use super::options::{Options, is_scale_invariant};
use super::samples::Samples;
use crate::kernel::function::Exact;
use rayon::prelude::*;
use serde::Serialize;
use sinew_runtime::kernel::Kernel;

/// Candidates of epsilon: the mean distance is 1.
const EPSILONS: [f64; 7] = [0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0];
/// Candidates of the smoothing, in units of the kernel matrix's RMS entry.
const SMOOTHINGS: [f64; 6] = [0.0, 1e-8, 1e-6, 1e-4, 1e-2, 1.0];
/// Halvings of the grid's steps, in logarithms, about the best candidate.
const HALVINGS: usize = 4;

/// What of the options is to be chosen; the rest stays what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Freedom {
    /// Epsilon, where it changes anything.
    pub epsilon: bool,
    /// The smoothing.
    pub smoothing: bool,
}

impl Freedom {
    /// Both are chosen.
    pub const ALL: Self = Self { epsilon: true, smoothing: true };
}

/// Options that predict left-out samples best.
#[derive(Clone, Debug)]
pub struct Choice {
    /// The options.
    pub options: Options,
    /// Every candidate, in the order in which they were tried.
    pub tried: Vec<Tried>,
}

/// A candidate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tried {
    /// What distances are multiplied by.
    pub epsilon: f64,
    /// λ.
    pub smoothing: f64,
    /// RMS error of samples that are left out, of each value over its spread; none where the fit is
    /// refused or samples cannot be left out.
    pub error: Option<f64>,
}

impl Choice {
    /// Tries epsilon and smoothing on a grid, then about the best at half the steps, four times; each
    /// by the errors of groups of samples that are left out. Epsilon stays what it is where it changes
    /// nothing. Kernels that do not reach the next sample are left alone: where samples say little of
    /// each other these err least, and make a spike of each.
    ///
    /// # Errors
    /// Those of [`Options::check`]; if no candidate's fit can leave the groups out.
    pub fn new(
        samples: &Samples,
        options: &Options,
        freedom: Freedom,
        groups: &[Vec<usize>],
    ) -> Result<Self, KernelError> {
        options.check()?;
        let fixed = !freedom.epsilon || is_scale_invariant(options.kernel);
        let apart = spacing(samples);
        let joins = |epsilon: &f64| fixed || reaches(options.kernel, epsilon * apart);
        let epsilons = if fixed { vec![options.epsilon] } else { EPSILONS.to_vec() };
        let shares = if freedom.smoothing { SMOOTHINGS.to_vec() } else { vec![0.0] };
        let judge = Judge { samples, options, freedom, groups, spreads: spreads(samples) };
        let grid: Vec<Place> = epsilons
            .iter()
            .filter(|epsilon| joins(epsilon))
            .flat_map(|&epsilon| shares.iter().map(move |&share| Place { epsilon, share }))
            .collect();
        let mut all = judge.all(&grid);
        let mut best = least(&all).ok_or(KernelError::NoChoice)?;
        for halving in 1..=HALVINGS {
            let step = 0.5f64.powi(halving as i32);
            // The grid's steps are a factor of 2 and of 100.
            let (wider, smoother) = (2f64.powf(step), 100f64.powf(step));
            let Place { epsilon, share } = best.place;
            let epsilons = [epsilon / wider, epsilon * wider].into_iter().filter(joins);
            let shares = [share / smoother, share * smoother].map(|share| Place { epsilon, share });
            let mut near = Vec::new();
            near.extend(epsilons.filter(|_| !fixed).map(|epsilon| Place { epsilon, share }));
            near.extend(shares.into_iter().filter(|place| place.share > 0.0));
            all.extend(judge.all(&near));
            best = least(&all).unwrap_or(best);
        }
        let Tried { epsilon, smoothing, .. } = best.tried;
        let options = Options { epsilon, smoothing, ..*options };
        Ok(Self { options, tried: all.iter().map(|candidate| candidate.tried).collect() })
    }
}

/// Where a candidate is, its smoothing in units of the kernel matrix's RMS entry.
#[derive(Clone, Copy)]
struct Place {
    epsilon: f64,
    share: f64,
}

#[derive(Clone, Copy)]
struct Candidate {
    place: Place,
    tried: Tried,
}

/// What candidates are judged by.
struct Judge<'a> {
    samples: &'a Samples,
    options: &'a Options,
    freedom: Freedom,
    groups: &'a [Vec<usize>],
    /// Of each value, m.
    spreads: Vec<f64>,
}

impl Judge<'_> {
    fn all(&self, places: &[Place]) -> Vec<Candidate> {
        places.par_iter().map(|&place| Candidate { place, tried: self.one(place) }).collect()
    }

    fn one(&self, place: Place) -> Tried {
        let points = self.samples.scaling.apply(&self.samples.sites) * faer::Scale(place.epsilon);
        let unit = match place.share {
            0.0 => 0.0,
            _ => gram(self.options.kernel, &points).norm_l2() / points.nrows() as f64,
        };
        // Where it is not chosen it is the one asked for; the share of it is then 0.
        let given = if self.freedom.smoothing { 0.0 } else { self.options.smoothing };
        let (epsilon, smoothing) = (place.epsilon, given + place.share * unit);
        let options = Options { epsilon, smoothing, ..*self.options };
        let squares = Fit::new(self.samples, &options)
            .ok()
            .and_then(|fit| fit.leave_one_out().mean_squares(self.groups));
        let error = squares.map(|squares| {
            let shares = squares.iter().zip(&self.spreads).map(|(square, s)| square / (s * s));
            (shares.sum::<f64>() / squares.len() as f64).sqrt()
        });
        Tried { epsilon, smoothing, error }
    }
}

/// Returns how far a sample is from the nearest other one, on average; 0 of a single one.
fn spacing(samples: &Samples) -> f64 {
    let points = samples.scaling.apply(&samples.sites);
    let n = points.nrows();
    let mut nearest = vec![f64::INFINITY; n];
    for from in 0..n {
        for (at, distance) in (from..n).zip(distances(&points, from)).skip(1) {
            nearest[from] = nearest[from].min(distance);
            nearest[at] = nearest[at].min(distance);
        }
    }
    if n > 1 { nearest.iter().sum::<f64>() / n as f64 } else { 0.0 }
}

/// Tells whether a kernel has not fallen below 1/e of its peak at a distance.
fn reaches(kernel: Kernel, distance: f64) -> bool {
    kernel.exact(distance * distance) >= kernel.exact(0.0) * (-1f64).exp()
        || kernel.exact(0.0) <= 0.0
}

/// Returns the candidate of least error, the first of equals; none where no error is known.
fn least(candidates: &[Candidate]) -> Option<Candidate> {
    let error = |candidate: &Candidate| candidate.tried.error.unwrap_or(f64::INFINITY);
    let least = candidates.iter().min_by(|a, b| error(a).total_cmp(&error(b)));
    least.filter(|candidate| candidate.tried.error.is_some()).copied()
}

/// Returns the standard deviation of each value, 1 of one that is constant.
fn spreads(samples: &Samples) -> Vec<f64> {
    let spread = |o: usize| {
        let values: Vec<f64> = samples.values.col(o).iter().copied().collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let squares: f64 = values.iter().map(|y| (y - mean) * (y - mean)).sum();
        let spread = (squares / values.len() as f64).sqrt();
        if spread > 0.0 { spread } else { 1.0 }
    };
    (0..samples.values.ncols()).map(spread).collect()
}
