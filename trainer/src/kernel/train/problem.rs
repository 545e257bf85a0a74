//! From a problem to a function with its names.

use super::error::TrainError;
use super::fitted::Fitted;
use super::matrices::Matrices;
use super::report::Trained;
use super::{learned, modes, solved};
use crate::kernel::fade::Fade;
use crate::kernel::model::{KernelModel, OutputKind};
use crate::kernel::problem::{Mode, Problem};
use crate::kernel::sum::KernelSum;
use crate::numeric::columns::ends;
use faer::Mat;
use sinew_runtime::kernel::Normalise;

/// Fits a problem.
///
/// - `variance`: whether what the variance takes is kept.
///
/// # Errors
/// [`TrainError`]: a site or a value that is none, options that do not fit each other, and what the fit
/// itself refuses.
pub fn train(problem: &Problem, variance: bool) -> Result<Trained, TrainError> {
    let mut outputs = problem.outputs.clone();
    let Matrices { features, values } = Matrices::new(problem, &mut outputs)?;
    let options = &problem.options;
    let fitted = match (options.mode, &options.learn) {
        (Mode::Sinew, None) => solved::fit(problem, &features, &values, variance)?,
        (Mode::Sinew, Some(learn)) => learned::fit(problem, learn, &features, &values)?,
        (Mode::Scipy, _) => modes::scipy(problem, &features, &values)?,
        (Mode::Published, _) => modes::published(problem, &features, &values)?,
    };
    let Fitted { sum, variance: kept, figures, report, mut warnings } = fitted;
    if variance && kept.is_none() {
        return Err(TrainError::NoVariance);
    }
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
        fade: fade(&sum, &features),
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
    Ok(Trained { model, report, warnings })
}

/// Fades beyond the farthest that a sample is from the centres that are not its own.
fn fade(sum: &KernelSum, features: &Mat<f64>) -> Fade {
    let mut farthest = 0.0f64;
    for site in features.row_iter() {
        let x: Vec<f64> = site.iter().copied().collect();
        let z = sum.measured(&sum.scaled(&x));
        let others = sum.squared_distances(&z).filter(|s| *s > 0.0);
        let nearest = others.fold(f64::INFINITY, f64::min);
        farthest = if nearest.is_finite() { farthest.max(nearest) } else { farthest };
    }
    Fade::beyond(farthest)
}
