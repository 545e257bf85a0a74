//! A fit with learned centres and metric.

use super::error::TrainError;
use super::fitted::Fitted;
use super::modes::residual_rms;
use super::report::{LearnReport, Report};
use super::solved::{degree_of, kernel, samples};
use crate::regression::function::order;
use crate::scattered::bound::{largest, rounded};
use crate::scattered::hyper::{Entries, Metric, Options, Start, learn};
use crate::scattered::model::Figures;
use crate::scattered::problem::{Learn, LearnMetric, Problem};
use crate::scattered::sum::monomials;
use faer::Mat;

/// Centres that are learned where no number is asked for, and samples are as many.
const CENTRES: usize = 12;

pub(super) fn fit(
    problem: &Problem,
    asked: &Learn,
    features: &Mat<f64>,
    values: &Mat<f64>,
) -> Result<Fitted, TrainError> {
    let own = &problem.options;
    if own.neighbors.is_some() || own.centres.is_some() || own.smoothing.is_some() {
        return Err(TrainError::Options(
            "learned centres have `centres` and `ridge` of their own, in `learn`",
        ));
    }
    let samples = samples(problem, features, values)?;
    let d = features.ncols();
    let kernel = kernel(own.kernel.as_deref().unwrap_or("gaussian"), samples.scaling.kept().len())?;
    let degree = match own.degree {
        Some(degree) => degree_of(degree)?,
        None => order(kernel).unwrap_or(0).checked_sub(1),
    };
    let terms = degree.map_or(0, |degree| monomials(d, degree).len());
    let most = samples.sample_len().saturating_sub(terms).max(1);
    let centres = asked.centres.unwrap_or(CENTRES.min(most));
    let epsilon = own.epsilon.unwrap_or_else(|| spacing(centres, samples.scaling.kept().len()));
    let rows = asked.rank.unwrap_or(d).clamp(1, d);
    let learned = match asked.metric {
        _ if rows < d => Entries::All,
        LearnMetric::Fixed => Entries::None,
        LearnMetric::Diagonal => Entries::Diagonal,
        LearnMetric::Full => Entries::All,
    };
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
    let residual_rms = residual_rms(&found.sum, sites, values);
    let bound = largest(&rounded(&found.sum), sites).into_iter().fold(0.0, f64::max);
    let best = &found.traces[found.best];
    let relevance = match &found.sum.metric {
        Some(w) => w.col_iter().map(|column| column.norm_l2()).collect(),
        None => vec![1.0; d],
    };
    let last = |trace: &crate::scattered::hyper::Trace| {
        trace.steps.iter().rev().find(|step| step.accepted).map_or(trace.start, |step| step.energy)
    };
    let report = LearnReport {
        energy: found.energy,
        residual_rms,
        seed: best.seed,
        trace: best.steps.iter().filter(|step| step.accepted).map(|step| step.energy).collect(),
        energies: found.traces.iter().map(last).collect(),
        relevance,
        bound,
    };
    let figures = Figures { residual_rms, left_out_rms: 0.0, bound, rcond: 0.0 };
    let (sum, report) = (found.sum, Report::Learned(report));
    let warnings = Vec::new();
    Ok(Fitted { sum, variance: None, figures, report, is_narrow: false, warnings })
}

/// Returns what makes the distance of n centres in a cube of d inputs 1, where the mean distance of
/// samples in it is: the side is √(6/d), nearly.
fn spacing(centres: usize, inputs: usize) -> f64 {
    let d = inputs.max(1) as f64;
    (centres as f64).powf(1.0 / d) * (d / 6.0).sqrt()
}
