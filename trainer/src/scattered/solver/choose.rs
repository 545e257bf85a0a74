//! Choice of width and smoothing, by leaving samples out (METHOD §2.2).

use super::fit::Fit;
use super::matrix::{distances, gram};
use super::options::Options;
use super::refusal::Refusal;
use super::samples::{ONE_SITE, Samples};
use crate::Error;
use crate::regression::function::{Exact, is_scale_invariant};
use crate::scattered::deviation::{Probe, ROOM};
use crate::scattered::sum::KernelSum;
use rayon::prelude::*;
use sinew_runtime::kernel::Kernel;
use std::cell::OnceCell;

/// Least candidate of epsilon, the widest kernel, in distances whose mean is 1. Each next candidate is twice as large.
const WIDEST: f64 = 0.125;
/// Largest candidate of epsilon, the narrowest kernel, unless neighbours are closer than its width.
const NARROW: f64 = 8.0;
/// Largest mean distance of neighbours in widths, if no width that joins them can be evaluated.
const APART: f64 = 8.0;
/// Factor between these narrower candidates of epsilon, 2^(1/4).
const STEP: f64 = 1.189_207_115_002_721;
/// Candidates of the smoothing, in units of the kernel matrix's RMS entry.
const SMOOTHINGS: [f64; 6] = [0.0, 1e-8, 1e-6, 1e-4, 1e-2, 1.0];
/// Number of times that the grid's steps are halved, in logarithms, around the best candidate.
const HALVINGS: usize = 4;

/// Options to choose. All other options stay unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Freedom {
    /// Chooses epsilon, if the kernel has a width.
    pub epsilon: bool,
    /// Chooses the smoothing.
    pub smoothing: bool,
}

/// Options that predict left-out samples best.
#[derive(Clone, Debug)]
pub struct Choice {
    /// Chosen options.
    pub options: Options,
    /// Whether the kernels do not reach the next sample, because no wider kernel can be evaluated.
    pub is_narrow: bool,
}

impl Choice {
    /// Tries epsilon and smoothing on a grid, then four times around the best candidate, with half the steps each time.
    ///
    /// A candidate's error comes from groups of samples that are left out. If epsilon changes nothing, it stays as
    /// given. If no group can be left out, epsilon stays as near to the given value as possible.
    ///
    /// Kernels that do not reach the next sample are excluded. If samples say little about each other, these kernels
    /// would have the least error, and each sample would become a spike. With a `probe`, kernels whose file deviates
    /// too far are excluded too. If no kernel is left, the widest of the narrower kernels is chosen, as long as
    /// neighbours are at most eight widths apart.
    ///
    /// # Errors
    /// - Errors of [`Options::check`].
    /// - If no candidate can be fitted.
    /// - If every candidate's file deviates too far.
    /// - If the smoothing is free and no candidate can leave the groups out.
    pub fn new(
        samples: &Samples,
        options: &Options,
        freedom: Freedom,
        groups: &[Vec<usize>],
        probe: Option<&Probe>,
    ) -> Result<Self, Error> {
        options.check()?;
        let fixed = !freedom.epsilon || is_scale_invariant(options.kernel);
        let apart = Spacing::new(samples).mean;
        let joins = |epsilon: &f64| fixed || reaches(options.kernel, epsilon * apart);
        let epsilons = if fixed { vec![options.epsilon] } else { epsilons(apart, joins) };
        let shares = if freedom.smoothing { SMOOTHINGS.to_vec() } else { vec![0.0] };
        let judge = Judge { samples, options, freedom, groups, spreads: spreads(samples), probe };
        let grid: Vec<GridPoint> =
            epsilons.iter().flat_map(|&epsilon| grid_points(epsilon, &shares)).collect();
        let mut all = judge.all(&grid);
        if !fixed
            && apart > 0.0
            && let Err(error) = judge.best(&all)
            && Refusal::of(&error).is_some()
        {
            let widest = epsilons.last().copied().unwrap_or(WIDEST);
            let options = judge.narrower(&shares, [widest, APART / apart]).ok_or(error)?;
            return Ok(Self { options, is_narrow: !joins(&options.epsilon) });
        }
        for halving in 1..=HALVINGS {
            let step = 0.5f64.powi(halving as i32);
            // The grid's steps are factors of 2 and of 100.
            let (wider, smoother) = (2f64.powf(step), 100f64.powf(step));
            let &Candidate { options: Options { epsilon, .. }, share, .. } = judge.best(&all)?;
            let epsilons = [epsilon / wider, epsilon * wider].into_iter().filter(joins);
            let shares =
                [share / smoother, share * smoother].map(|share| GridPoint { epsilon, share });
            let mut near = Vec::new();
            near.extend(epsilons.filter(|_| !fixed).map(|epsilon| GridPoint { epsilon, share }));
            near.extend(shares.into_iter().filter(|point| point.share > 0.0));
            all.extend(judge.all(&near));
        }
        Ok(Self { options: judge.best(&all)?.options, is_narrow: false })
    }
}

/// Lists the first candidates of epsilon: by factors of 2, up to the spacing of the samples.
///
/// - `apart`: mean distance between neighbours.
/// - `joins`: whether the kernels of an epsilon reach the next sample.
fn epsilons(apart: f64, joins: impl Fn(&f64) -> bool) -> Vec<f64> {
    let widest = std::iter::successors(Some(WIDEST), |epsilon| Some(0.5 * epsilon)).find(&joins);
    let all = std::iter::successors(widest, |epsilon| Some(2.0 * epsilon));
    all.take_while(|epsilon| *epsilon <= NARROW || epsilon * apart <= 1.0).filter(joins).collect()
}

/// Candidate's epsilon, and its smoothing in units of the kernel matrix's RMS entry.
#[derive(Clone, Copy)]
struct GridPoint {
    epsilon: f64,
    share: f64,
}

struct Candidate {
    options: Options,
    /// Smoothing, in units of the kernel matrix's RMS entry.
    share: f64,
    /// RMS error of left-out samples, of each value over its spread; `None` if the fit is refused or samples cannot be
    /// left out.
    error: Option<f64>,
    /// Fitted function, or the reason why there is none.
    sum: Result<KernelSum, Error>,
    /// Deviation of the function's file, over the limit.
    deviation: OnceCell<f64>,
}

/// Samples and rules that give each candidate its error.
struct Judge<'a> {
    samples: &'a Samples,
    options: &'a Options,
    freedom: Freedom,
    groups: &'a [Vec<usize>],
    /// Spread of each value, m.
    spreads: Vec<f64>,
    probe: Option<&'a Probe>,
}

impl Judge<'_> {
    fn all(&self, points: &[GridPoint]) -> Vec<Candidate> {
        points.par_iter().map(|&point| self.one(point)).collect()
    }

    fn one(&self, point: GridPoint) -> Candidate {
        let points = self.samples.scaling.apply(&self.samples.sites) * faer::Scale(point.epsilon);
        let unit = match point.share {
            0.0 => 0.0,
            _ => gram(self.options.kernel, &points).norm_l2() / points.nrows() as f64,
        };
        // A fixed smoothing is the given one, and its share is then 0.
        let given = if self.freedom.smoothing { 0.0 } else { self.options.smoothing };
        let (epsilon, smoothing) = (point.epsilon, given + point.share * unit);
        let options = Options { epsilon, smoothing, ..*self.options };
        let fit = Fit::new(self.samples, &options);
        let squares =
            fit.as_ref().ok().and_then(|fit| fit.leave_one_out().mean_squares(self.groups));
        let error = squares.map(|squares| {
            let shares = squares.iter().zip(&self.spreads).map(|(square, s)| square / (s * s));
            (shares.sum::<f64>() / squares.len() as f64).sqrt()
        });
        let sum = fit.map(|fit| fit.sum);
        Candidate { options, share: point.share, error, sum, deviation: OnceCell::new() }
    }

    /// Finds the widest kernels with an acceptable fit.
    ///
    /// - `widest`: epsilon that is too wide.
    /// - `most`: largest epsilon to try.
    fn narrower(&self, shares: &[f64], [widest, most]: [f64; 2]) -> Option<Options> {
        // Deviations do not fall evenly, because of rounding.
        let steps = std::iter::successors(Some(widest), |epsilon| Some(STEP * epsilon)).skip(1);
        steps.take_while(|epsilon| *epsilon <= most).find_map(|epsilon| {
            let own = self.all(&grid_points(epsilon, shares).collect::<Vec<_>>());
            Some(self.best(&own).ok()?.options)
        })
    }

    /// Returns the candidate with the least error whose file is within the limit; the first if errors are equal.
    ///
    /// If no error is known, this returns the candidate whose epsilon is nearest to the given one.
    ///
    /// # Errors
    /// Errors of [`Choice::new`].
    fn best<'c>(&self, all: &'c [Candidate]) -> Result<&'c Candidate, Error> {
        let known = all.iter().any(|candidate| candidate.error.is_some());
        let fitted = all.iter().any(|candidate| candidate.sum.is_ok());
        if fitted && !known && self.freedom.smoothing {
            return Err(no_choice());
        }
        let score = |candidate: &Candidate| match known {
            true => candidate.error.unwrap_or(f64::INFINITY),
            false => (candidate.options.epsilon / self.options.epsilon).log2().abs(),
        };
        let is_scored =
            |candidate: &&Candidate| candidate.sum.is_ok() && (candidate.error.is_some() || !known);
        let mut order: Vec<&Candidate> = all.iter().filter(is_scored).collect();
        order.sort_by(|a, b| score(a).total_cmp(&score(b)));
        let within = |room: f64| order.iter().find(|candidate| self.deviation(candidate) <= room);
        if let Some(best) = within(ROOM).or_else(|| within(1.0)) {
            return Ok(best);
        }
        let least = order.iter().min_by(|a, b| self.deviation(a).total_cmp(&self.deviation(b)));
        Err(match (least.map(|least| (&least.sum, self.deviation(least))), self.probe) {
            (Some((Ok(sum), least)), Some(probe)) => {
                probe.refusal(probe.limit * least, sum.kernel, |x| sum.evaluate(x))
            }
            _ => self.best_conditioned(all),
        })
    }

    /// Returns the error of the best-conditioned candidate, if no candidate was fitted.
    fn best_conditioned(&self, all: &[Candidate]) -> Error {
        let reason = |candidate: &Candidate| candidate.sum.as_ref().err().and_then(Refusal::of);
        let rcond = |candidate: &&Candidate| match reason(candidate) {
            Some(Refusal::IllConditioned { rcond, .. }) => rcond,
            _ => 0.0,
        };
        let refused = all.iter().filter(|candidate| candidate.sum.is_err());
        let Some(best) = refused.max_by(|a, b| rcond(a).total_cmp(&rcond(b))) else {
            return no_choice();
        };
        // An error has no copy, so the fit is repeated.
        Fit::new(self.samples, &best.options).err().unwrap_or_else(no_choice)
    }

    /// Returns the deviation of a candidate's file, over the limit; 0 without a probe.
    fn deviation(&self, candidate: &Candidate) -> f64 {
        *candidate.deviation.get_or_init(|| match (self.probe, &candidate.sum) {
            (Some(probe), Ok(sum)) => probe.deviation(sum, |x| sum.evaluate(x)) / probe.limit,
            _ => 0.0,
        })
    }
}

/// Lists the candidates of an epsilon.
fn grid_points(epsilon: f64, shares: &[f64]) -> impl Iterator<Item = GridPoint> {
    shares.iter().map(move |&share| GridPoint { epsilon, share })
}

/// Returns the error if the smoothing is free, and no candidate can predict samples that it has not seen.
fn no_choice() -> Error {
    Error::fit(
        "no smoothing can be chosen: it takes samples that the others predict, and there are too few (or too few \
         groups); give `smoothing` a number",
    )
}

/// Returns true if a kernel's value at a distance is at least 1/e of its peak.
fn reaches(kernel: Kernel, distance: f64) -> bool {
    kernel.exact(distance * distance) >= kernel.exact(0.0) * (-1f64).exp()
        || kernel.exact(0.0) <= 0.0
}

/// Returns the standard deviation of each value; 1 for a constant value.
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

/// Distances between nearest samples, over the mean distance of all.
pub struct Spacing {
    /// Mean distance from a sample to the nearest other site; 0 for a single site.
    pub mean: f64,
    /// Distance of the two nearest samples; infinite for a single sample.
    pub least: f64,
    /// Indices of the two nearest samples.
    pub nearest: [usize; 2],
}

impl Spacing {
    /// Measures the spacing of samples.
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
