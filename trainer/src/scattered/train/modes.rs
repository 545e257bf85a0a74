//! Fits by the rules of others.

use super::error::TrainError;
use super::fitted::Fitted;
use super::report::Report;
use super::solved::{NEIGHBOURS, kernel};
use crate::scattered::bound::{largest, rounded};
use crate::scattered::compat::published::{Published, PublishedKernel, PublishedOptions};
use crate::scattered::compat::scipy::{RbfInterpolator, ScipyOptions, Smoothing as ScipySmoothing};
use crate::scattered::model::Figures;
use crate::scattered::problem::{Problem, Smoothing};
use crate::scattered::sum::KernelSum;
use faer::Mat;
use sinew_runtime::kernel::Kernel;

/// Condition above which S2's normal equations are warned of: its square is what they work with.
const CONDITION: f64 = 1e5;

pub(super) fn scipy(
    problem: &Problem,
    features: &Mat<f64>,
    values: &Mat<f64>,
) -> Result<Fitted, TrainError> {
    let own = &problem.options;
    if own.neighbors.is_some() {
        return Err(NEIGHBOURS);
    }
    let default = ScipyOptions::default();
    let smoothing = match &own.smoothing {
        Some(Smoothing::Given(smoothing)) => ScipySmoothing::All(*smoothing),
        Some(Smoothing::Each(all)) => ScipySmoothing::Each(all.clone()),
        Some(Smoothing::Chosen) => {
            return Err(TrainError::Options("SciPy chooses no smoothing: give a number"));
        }
        None => default.smoothing,
    };
    let options = ScipyOptions {
        kernel: own.kernel.clone().unwrap_or(default.kernel),
        epsilon: own.epsilon,
        smoothing,
        degree: own.degree,
        neighbors: None,
    };
    let fit = RbfInterpolator::new(features, values, &options)?;
    let warnings = fit.warnings.iter().map(ToString::to_string).collect();
    let (sum, rcond) = fit.whole().ok_or(NEIGHBOURS)?;
    Ok(fitted(sum.clone(), *rcond, features, values, warnings))
}

pub(super) fn published(
    problem: &Problem,
    features: &Mat<f64>,
    values: &Mat<f64>,
) -> Result<Fitted, TrainError> {
    let own = &problem.options;
    let name = own.kernel.as_deref().unwrap_or("linear");
    let kernel = match kernel(name, 3)? {
        Kernel::Linear => PublishedKernel::Linear,
        Kernel::Gaussian => PublishedKernel::Gaussian,
        Kernel::ThinPlate => PublishedKernel::ThinPlate,
        Kernel::Multiquadric => PublishedKernel::MultiQuadraticBiharmonic,
        Kernel::InverseMultiquadric => PublishedKernel::InverseMultiQuadraticBiharmonic,
        Kernel::Wendland { .. } => PublishedKernel::BeckertWendlandC2,
        _ => {
            return Err(TrainError::Options(
                "the published solver has six kernels: linear, gaussian, thin plate, multiquadric, \
                 inverse multiquadric and Wendland",
            ));
        }
    };
    let regularization = match &own.smoothing {
        Some(Smoothing::Given(smoothing)) => *smoothing,
        Some(Smoothing::Each(_)) => {
            return Err(TrainError::Options(
                "the published solver has one smoothing for all samples",
            ));
        }
        Some(Smoothing::Chosen) => {
            return Err(TrainError::Options("the published solver chooses no smoothing"));
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
    let fit = Published::new(features, values, &options)?;
    let mut warnings = Vec::new();
    if fit.condition.is_nan() || fit.condition > CONDITION {
        warnings.push(format!(
            "its matrix has condition {:.1e}, which normal equations square: samples may be missed",
            fit.condition
        ));
    }
    Ok(fitted(fit.sum, 1.0 / fit.condition, features, values, warnings))
}

fn fitted(
    sum: KernelSum,
    rcond: f64,
    features: &Mat<f64>,
    values: &Mat<f64>,
    warnings: Vec<String>,
) -> Fitted {
    let residual_rms = residual_rms(&sum, features, values);
    let bound = largest(&rounded(&sum), features).into_iter().fold(0.0, f64::max);
    let figures = Figures { residual_rms, left_out_rms: 0.0, bound, rcond };
    let report = Report::Mode { rcond, residual_rms };
    Fitted { sum, variance: None, figures, report, is_narrow: false, warnings }
}

/// Measures what a function leaves of values at their sites.
pub(super) fn residual_rms(sum: &KernelSum, features: &Mat<f64>, values: &Mat<f64>) -> f64 {
    let mut squares = 0.0;
    for (site, own) in features.row_iter().zip(values.row_iter()) {
        let found = sum.evaluate(&site.iter().copied().collect::<Vec<_>>());
        squares += own.iter().zip(&found).map(|(y, f)| (y - f) * (y - f)).sum::<f64>();
    }
    (squares / (values.nrows() * values.ncols()) as f64).sqrt()
}
