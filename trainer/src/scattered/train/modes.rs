//! Fits by the rules of other solvers, and fits with learned centres and metric.

use super::report::{Fitted, LearnReport, Report};
use super::solved::{Data, degree_of, kernel, neighbours, samples};
use crate::Error;
use crate::regression::function::order;
use crate::scattered::bound::{largest, rounded};
use crate::scattered::compat::published::{Published, PublishedKernel, PublishedOptions};
use crate::scattered::compat::scipy::{RbfInterpolator, ScipyOptions};
use crate::scattered::hyper::{Entries, Metric, Options, Start, Trace, learn};
use crate::scattered::model::Figures;
use crate::scattered::problem::{Learn, Smoothing};
use crate::scattered::sum::{KernelSum, monomials};
use faer::Mat;
use sinew_runtime::kernel::Kernel;

/// Condition above which S2's solver has a warning: its normal equations square the condition.
const CONDITION: f64 = 1e5;

pub(super) fn scipy(of: &Data<'_>) -> Result<Fitted, Error> {
    let own = &of.problem.options;
    if own.neighbors.is_some() {
        return Err(neighbours());
    }
    let options = ScipyOptions {
        kernel: own.kernel.clone(),
        epsilon: own.epsilon,
        smoothing: own.smoothing.clone(),
        degree: own.degree,
        neighbors: None,
    };
    let fit = RbfInterpolator::new(of.features, of.values, &options)?;
    let (sum, rcond) = fit.whole.ok_or_else(neighbours)?;
    Ok(fitted(of, sum, rcond, fit.warnings))
}

pub(super) fn published(of: &Data<'_>) -> Result<Fitted, Error> {
    let own = &of.problem.options;
    let name = own.kernel.as_deref().unwrap_or("linear");
    let kernel = match kernel(name, 3)? {
        Kernel::Linear => PublishedKernel::Linear,
        Kernel::Gaussian => PublishedKernel::Gaussian,
        Kernel::ThinPlate => PublishedKernel::ThinPlate,
        Kernel::Multiquadric => PublishedKernel::MultiQuadraticBiharmonic,
        Kernel::InverseMultiquadric => PublishedKernel::InverseMultiQuadraticBiharmonic,
        Kernel::Wendland { .. } => PublishedKernel::BeckertWendlandC2,
        _ => {
            return Err(Error::unsupported(
                "the published solver has six kernels: linear, gaussian, thin plate, multiquadric, \
                 inverse multiquadric and Wendland",
            ));
        }
    };
    let regularization = match &own.smoothing {
        Some(Smoothing::Given(smoothing)) => *smoothing,
        Some(Smoothing::Each(_)) => {
            return Err(Error::unsupported(
                "the published solver has one smoothing for all samples",
            ));
        }
        Some(Smoothing::Chosen) => {
            return Err(Error::unsupported("the published solver chooses no smoothing"));
        }
        None => 0.0,
    };
    let options = PublishedOptions {
        kernel,
        radius: own.radius.unwrap_or(1.0),
        regularization,
        normalise_features: own.normalise_features,
        normalise_distances: kernel != PublishedKernel::Linear,
    };
    let fit = Published::new(of.features, of.values, &options)?;
    let mut warnings = Vec::new();
    if fit.condition.is_nan() || fit.condition > CONDITION {
        warnings.push(format!(
            "its matrix has condition {:.1e}, which normal equations square: samples may be missed",
            fit.condition
        ));
    }
    Ok(fitted(of, fit.sum, 1.0 / fit.condition, warnings))
}

fn fitted(of: &Data<'_>, sum: KernelSum, rcond: f64, warnings: Vec<String>) -> Fitted {
    let figures = figures(&sum, of.features, of.values, rcond);
    let report = Report::Mode { rcond, residual_rms: figures.residual_rms };
    Fitted { sum, variance: None, figures, report, is_narrow: false, warnings }
}

/// Measures a function of values at their sites.
fn figures(sum: &KernelSum, sites: &Mat<f64>, values: &Mat<f64>, rcond: f64) -> Figures {
    let mut squares = 0.0;
    for (site, own) in sites.row_iter().zip(values.row_iter()) {
        let found = sum.evaluate(&site.iter().copied().collect::<Vec<_>>());
        squares += own.iter().zip(&found).map(|(y, f)| (y - f) * (y - f)).sum::<f64>();
    }
    let residual_rms = (squares / (values.nrows() * values.ncols()) as f64).sqrt();
    let bound = largest(&rounded(sum), sites).into_iter().fold(0.0, f64::max);
    Figures { residual_rms, left_out_rms: 0.0, bound, rcond }
}

/// Default number of learned centres, if there are enough samples.
const CENTRES: usize = 12;

pub(super) fn learned(of: &Data<'_>, asked: &Learn) -> Result<Fitted, Error> {
    let own = &of.problem.options;
    if own.neighbors.is_some() || own.centres.is_some() || own.smoothing.is_some() {
        return Err(Error::unsupported(
            "learned centres have their own `centres` and `ridge`, in `learn`",
        ));
    }
    let samples = samples(of)?;
    let d = of.features.ncols();
    let kernel = kernel(own.kernel.as_deref().unwrap_or("gaussian"), samples.scaling.kept().len())?;
    let degree = match own.degree {
        Some(degree) => degree_of(degree)?,
        None => order(kernel).unwrap_or(0).checked_sub(1),
    };
    let terms = degree.map_or(0, |degree| monomials(d, degree).len());
    let most = samples.sample_len().saturating_sub(terms).max(1);
    let centres = asked.centres.unwrap_or(CENTRES.min(most));
    let epsilon =
        own.epsilon.unwrap_or_else(|| spacing_factor(centres, samples.scaling.kept().len()));
    let rows = asked.rank.unwrap_or(d).clamp(1, d);
    let learned = if rows < d { Entries::All } else { asked.metric };
    let options = Options {
        kernel,
        centres,
        degree,
        ridge: asked.ridge,
        metric: Metric::scaled(rows, d, epsilon, learned),
        start: Start::KMeansPlusPlus,
        method: asked.method.method(),
        seeds: (1..=asked.seeds).collect(),
        evaluations: asked.evaluations,
    };
    let (sites, values) = (&samples.sites, &samples.values);
    let scaling = &samples.scaling;
    let found = learn(sites.as_ref(), values.as_ref(), &scaling.shift, &scaling.scale, &options)?;
    let figures = figures(&found.sum, sites, values, 0.0);
    let best = &found.traces[found.best];
    let relevance = match &found.sum.metric {
        Some(w) => w.col_iter().map(|column| column.norm_l2()).collect(),
        None => vec![1.0; d],
    };
    let last = |trace: &Trace| {
        trace.steps.iter().rev().find(|step| step.accepted).map_or(trace.start, |step| step.energy)
    };
    let report = LearnReport {
        energy: found.energy,
        residual_rms: figures.residual_rms,
        seed: best.seed,
        trace: best.steps.iter().filter(|step| step.accepted).map(|step| step.energy).collect(),
        energies: found.traces.iter().map(last).collect(),
        relevance,
        bound: figures.bound,
    };
    let (sum, report) = (found.sum, Report::Learned(report));
    let warnings = Vec::new();
    Ok(Fitted { sum, variance: None, figures, report, is_narrow: false, warnings })
}

/// Returns the factor that makes the spacing of n centres 1.
///
/// The centres fill a cube of d inputs whose side is about √(6/d), because the mean distance of samples in the cube is
/// 1.
fn spacing_factor(centres: usize, inputs: usize) -> f64 {
    let d = inputs.max(1) as f64;
    (centres as f64).powf(1.0 / d) * (d / 6.0).sqrt()
}
