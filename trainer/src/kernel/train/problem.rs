//! From a problem to a function with its names.

use super::error::TrainError;
use super::fitted::Fitted;
use super::matrices::Matrices;
use super::report::Trained;
use super::{learned, modes, solved};
use crate::kernel::deviation::Probe;
use crate::kernel::fade::Fade;
use crate::kernel::model::{KernelModel, OutputKind};
use crate::kernel::problem::{Mode, Problem};
use crate::kernel::scattered::samples::{ONE_SITE, check, ranges};
use crate::kernel::sum::KernelSum;
use crate::numeric::columns::ends;
use faer::Mat;
use sinew_runtime::kernel::{Normalise, QueryRule};

/// Room for the rounding of a squared distance in f32: the sample that the fade starts at has confidence 1.
const ROOM: f64 = 1.0 + 1e-4;

/// Fits a problem.
///
/// - `variance`: whether what the variance takes is kept.
///
/// # Errors
/// [`TrainError`]: a site or a value that is none, options that do not fit each other, a refusal of the fit
/// itself, and a file whose deviation is above the limit of the options.
pub fn train(problem: &Problem, variance: bool) -> Result<Trained, TrainError> {
    let mut outputs = problem.outputs.clone();
    let Matrices { features, values } = Matrices::new(problem, &mut outputs)?;
    let options = &problem.options;
    let limit = options.f32_error;
    if !(limit > 0.0 && limit.is_finite()) {
        return Err(TrainError::F32Error(limit));
    }
    check(&features, &values)?;
    // The sites have become features, so they are sound.
    let probe = Probe::new(&problem.inputs, &problem.sites, ranges(&values), limit)
        .map_err(|error| TrainError::Site { row: 0, error })?;
    let fitted = match (options.mode, &options.learn) {
        (Mode::Sinew, None) => solved::fit(problem, &features, &values, &probe, variance)?,
        (Mode::Sinew, Some(learn)) => learned::fit(problem, learn, &features, &values)?,
        (Mode::Scipy, _) => modes::scipy(problem, &features, &values)?,
        (Mode::Published, _) => modes::published(problem, &features, &values)?,
    };
    let Fitted { sum, variance: kept, figures, report, mut warnings } = fitted;
    if variance && kept.is_none() {
        return Err(TrainError::NoVariance);
    }
    let deviation = probe.check(&sum, |x| sum.evaluate(x))?;
    let euler = problem.euler_inputs();
    if euler.len() > 1 {
        warnings.push(format!(
            "{} inputs are Euler angles ({}): they are taken as rotations, not as numbers",
            euler.len(),
            euler.join(", ")
        ));
    }
    let marked = |kind: &OutputKind| matches!(kind, OutputKind::Scalar { normalised: true, .. });
    let any = outputs.iter().any(|output| marked(&output.kind));
    let model = KernelModel {
        name: problem.name.clone(),
        inputs: problem.inputs.clone(),
        fade: fade(&sum, &features, options.outside)?,
        sum,
        ranges: features.col_iter().map(|column| ends(column.iter())).collect(),
        query: options.outside,
        normalise: options.normalise.unwrap_or(if any {
            Normalise::Always
        } else {
            Normalise::Never
        }),
        outputs,
        variance: kept,
        fit: figures,
    };
    Ok(Trained { model, report, deviation, warnings })
}

/// Fades beyond the farthest that a sample is from the centres that are not its own; a sample's own centre is
/// nearer than two sites that are one. Where there is no other centre any fade is as good: every query is at
/// the one, or it fades within a width of the kernel.
///
/// # Errors
/// If there is no centre to fade by.
fn fade(sum: &KernelSum, features: &Mat<f64>, outside: QueryRule) -> Result<Fade, TrainError> {
    if sum.centres.ncols() == 0 {
        return match outside {
            QueryRule::Fade => Err(TrainError::Options(
                "without a centre nothing fades: take 1 of `centres` or more, or clamp outside",
            )),
            QueryRule::Free | QueryRule::Clamp => Ok(Fade { start: 0.0, end: 0.0 }),
        };
    }
    let mut farthest = 0.0f64;
    for site in features.row_iter() {
        let x: Vec<f64> = site.iter().copied().collect();
        let z = sum.measured(&sum.scaled(&x));
        let all: Vec<f64> = sum.squared_distances(&z).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let others = all.iter().filter(|s| **s > ONE_SITE * ONE_SITE * mean);
        let nearest = others.copied().fold(f64::INFINITY, f64::min);
        farthest = if nearest.is_finite() { farthest.max(nearest) } else { farthest };
    }
    Ok(Fade::beyond(if farthest > 0.0 { ROOM * farthest } else { 1.0 }))
}
