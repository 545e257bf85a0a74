//! Width and smoothing, chosen by leaving samples out (METHOD §2.2).
//! How far samples are from their nearest ones.

use super::error::KernelError;
use super::fit::AnyFit;
use super::matrix::{distances, gram};
use super::options::Options;
use super::samples::{ONE_SITE, Samples};
use crate::regression::function::{Exact, is_scale_invariant};
use crate::scattered::deviation::{Probe, ROOM};
use crate::scattered::sum::KernelSum;
use rayon::prelude::*;
use serde::Serialize;
use sinew_runtime::kernel::Kernel;
use std::cell::OnceCell;

/// The widest candidate of epsilon, the mean distance being 1; each next one is twice as large.
const WIDEST: f64 = 0.125;
/// The narrowest that is tried of samples whose nearest neighbours are far apart.
const NARROW: f64 = 8.0;
/// How far apart samples may be on average, in widths, where no width that joins them can be evaluated.
const APART: f64 = 8.0;
/// Factor of epsilon from one of those widths to the next, 2^(1/4).
const STEP: f64 = 1.189_207_115_002_721;
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
    /// Whether kernels do not reach the next sample, as no wider ones can be evaluated.
    pub is_narrow: bool,
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
    /// nothing, and stays as near as it can where no group can be left out. Kernels that do not reach the next
    /// sample are left alone: where samples say little of each other their error is the least, and each sample
    /// becomes a spike. With a `probe`, kernels whose file deviates too far are left alone too. Where none is left the
    /// widest of the narrower kernels is taken, as long as samples are up to eight widths apart.
    ///
    /// # Errors
    /// Those of [`Options::check`]; if no candidate can be fitted; if none has a file that is near enough; if
    /// the smoothing is free and no candidate's fit can leave the groups out.
    pub fn new(
        samples: &Samples,
        options: &Options,
        freedom: Freedom,
        groups: &[Vec<usize>],
        probe: Option<&Probe>,
    ) -> Result<Self, KernelError> {
        options.check()?;
        let fixed = !freedom.epsilon || is_scale_invariant(options.kernel);
        let apart = Spacing::new(samples).mean;
        let joins = |epsilon: &f64| fixed || reaches(options.kernel, epsilon * apart);
        let epsilons = if fixed { vec![options.epsilon] } else { epsilons(apart, joins) };
        let shares = if freedom.smoothing { SMOOTHINGS.to_vec() } else { vec![0.0] };
        let judge = Judge { samples, options, freedom, groups, spreads: spreads(samples), probe };
        let grid: Vec<Place> =
            epsilons.iter().flat_map(|&epsilon| places(epsilon, &shares)).collect();
        let mut all = judge.all(&grid);
        if !fixed
            && apart > 0.0
            && let Err(error) = judge.best(&all)
            && error.is_of_width()
        {
            let widest = epsilons.last().copied().unwrap_or(WIDEST);
            let found = judge.narrower(&mut all, &shares, [widest, APART / apart]);
            let Tried { epsilon, smoothing, .. } = found.ok_or(error)?;
            let options = Options { epsilon, smoothing, ..*options };
            let tried = all.iter().map(|candidate| candidate.tried).collect();
            return Ok(Self { options, is_narrow: !joins(&epsilon), tried });
        }
        for halving in 1..=HALVINGS {
            let step = 0.5f64.powi(halving as i32);
            // The grid's steps are a factor of 2 and of 100.
            let (wider, smoother) = (2f64.powf(step), 100f64.powf(step));
            let Place { epsilon, share } = judge.best(&all)?.place;
            let epsilons = [epsilon / wider, epsilon * wider].into_iter().filter(joins);
            let shares = [share / smoother, share * smoother].map(|share| Place { epsilon, share });
            let mut near = Vec::new();
            near.extend(epsilons.filter(|_| !fixed).map(|epsilon| Place { epsilon, share }));
            near.extend(shares.into_iter().filter(|place| place.share > 0.0));
            all.extend(judge.all(&near));
        }
        let Tried { epsilon, smoothing, .. } = judge.best(&all)?.tried;
        let options = Options { epsilon, smoothing, ..*options };
        Ok(Self {
            options,
            is_narrow: false,
            tried: all.iter().map(|candidate| candidate.tried).collect(),
        })
    }
}

/// Lists the epsilons that are tried first: by factors of 2 up to the spacing of samples, `apart`.
fn epsilons(apart: f64, joins: impl Fn(&f64) -> bool) -> Vec<f64> {
    let widest = std::iter::successors(Some(WIDEST), |epsilon| Some(0.5 * epsilon)).find(&joins);
    let all = std::iter::successors(widest, |epsilon| Some(2.0 * epsilon));
    all.take_while(|epsilon| *epsilon <= NARROW || epsilon * apart <= 1.0).filter(joins).collect()
}

/// Where a candidate is, its smoothing in units of the kernel matrix's RMS entry.
#[derive(Clone, Copy)]
struct Place {
    epsilon: f64,
    share: f64,
}

struct Candidate {
    place: Place,
    tried: Tried,
    /// The function, or why there is none.
    sum: Result<KernelSum, KernelError>,
    /// Deviation of its file, over the limit.
    deviation: OnceCell<f64>,
}

/// What candidates are judged by.
struct Judge<'a> {
    samples: &'a Samples,
    options: &'a Options,
    freedom: Freedom,
    groups: &'a [Vec<usize>],
    /// Of each value, m.
    spreads: Vec<f64>,
    probe: Option<&'a Probe>,
}

impl Judge<'_> {
    fn all(&self, places: &[Place]) -> Vec<Candidate> {
        places.par_iter().map(|&place| self.one(place)).collect()
    }

    fn one(&self, place: Place) -> Candidate {
        let points = self.samples.scaling.apply(&self.samples.sites) * faer::Scale(place.epsilon);
        let unit = match place.share {
            0.0 => 0.0,
            _ => gram(self.options.kernel, &points).norm_l2() / points.nrows() as f64,
        };
        // Where it is not chosen it is the one asked for; the share of it is then 0.
        let given = if self.freedom.smoothing { 0.0 } else { self.options.smoothing };
        let (epsilon, smoothing) = (place.epsilon, given + place.share * unit);
        let options = Options { epsilon, smoothing, ..*self.options };
        let fit = AnyFit::new(self.samples, &options);
        let squares =
            fit.as_ref().ok().and_then(|fit| fit.leave_one_out().mean_squares(self.groups));
        let error = squares.map(|squares| {
            let shares = squares.iter().zip(&self.spreads).map(|(square, s)| square / (s * s));
            (shares.sum::<f64>() / squares.len() as f64).sqrt()
        });
        let tried = Tried { epsilon, smoothing, error };
        let sum = fit.map(|fit| fit.sum().clone());
        Candidate { place, tried, sum, deviation: OnceCell::new() }
    }

    /// Finds the widest kernels that are sound, narrower than an epsilon that is not; none up to the `most`.
    fn narrower(
        &self,
        all: &mut Vec<Candidate>,
        shares: &[f64],
        [widest, most]: [f64; 2],
    ) -> Option<Tried> {
        // By rounding, deviations do not fall evenly.
        let steps = std::iter::successors(Some(widest), |epsilon| Some(STEP * epsilon)).skip(1);
        steps.take_while(|epsilon| *epsilon <= most).find_map(|epsilon| {
            let own = self.all(&places(epsilon, shares).collect::<Vec<_>>());
            let found = self.best(&own).ok().map(|best| best.tried);
            all.extend(own);
            found
        })
    }

    /// Returns the candidate of least error whose file deviates little, the first of equals; where no error
    /// is known, the one whose epsilon is nearest to the one asked for.
    ///
    /// # Errors
    /// Those of [`Choice::new`].
    fn best<'c>(&self, all: &'c [Candidate]) -> Result<&'c Candidate, KernelError> {
        let known = all.iter().any(|candidate| candidate.tried.error.is_some());
        let fitted = all.iter().any(|candidate| candidate.sum.is_ok());
        if fitted && !known && self.freedom.smoothing {
            return Err(KernelError::NoChoice);
        }
        let far = |tried: &Tried| (tried.epsilon / self.options.epsilon).log2().abs();
        let score = |candidate: &Candidate| match known {
            true => candidate.tried.error.unwrap_or(f64::INFINITY),
            false => far(&candidate.tried),
        };
        let mut order: Vec<&Candidate> = all
            .iter()
            .filter(|candidate| {
                candidate.sum.is_ok() && (candidate.tried.error.is_some() || !known)
            })
            .collect();
        order.sort_by(|a, b| score(a).total_cmp(&score(b)));
        let within = |room: f64| order.iter().find(|candidate| self.deviation(candidate) <= room);
        if let Some(best) = within(ROOM).or_else(|| within(1.0)) {
            return Ok(best);
        }
        let least = order.iter().min_by(|a, b| self.deviation(a).total_cmp(&self.deviation(b)));
        Err(match (least.map(|least| (&least.sum, self.deviation(least))), self.probe) {
            (Some((Ok(sum), least)), Some(probe)) => {
                probe.refusal(probe.limit() * least, sum.kernel, |x| sum.evaluate(x))
            }
            _ => best_conditioned(all),
        })
    }

    /// Returns the deviation of a candidate's file, over the limit; 0 without a probe.
    fn deviation(&self, candidate: &Candidate) -> f64 {
        *candidate.deviation.get_or_init(|| match (self.probe, &candidate.sum) {
            (Some(probe), Ok(sum)) => probe.deviation(sum, |x| sum.evaluate(x)) / probe.limit(),
            _ => 0.0,
        })
    }
}

/// Lists the places of an epsilon.
fn places(epsilon: f64, shares: &[f64]) -> impl Iterator<Item = Place> {
    shares.iter().map(move |&share| Place { epsilon, share })
}

/// Returns why no candidate was fitted: the error of the one whose system is conditioned best.
fn best_conditioned(all: &[Candidate]) -> KernelError {
    let rcond = |error: &&KernelError| match error {
        KernelError::IllConditioned { rcond, .. } => *rcond,
        _ => 0.0,
    };
    let errors = all.iter().filter_map(|candidate| candidate.sum.as_ref().err());
    let best = errors.max_by(|a, b| rcond(a).total_cmp(&rcond(b)));
    best.cloned().unwrap_or(KernelError::NoChoice)
}

/// Tells whether a kernel has not fallen below 1/e of its peak at a distance.
fn reaches(kernel: Kernel, distance: f64) -> bool {
    kernel.exact(distance * distance) >= kernel.exact(0.0) * (-1f64).exp()
        || kernel.exact(0.0) <= 0.0
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
