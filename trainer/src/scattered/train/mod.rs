//! Training: fits a problem by METHOD §2, by SciPy's rules, by S2's rules, or with learned centres.

mod modes;
mod report;
mod solved;

pub use report::{LearnReport, Report, Trained};

use crate::Error;
use crate::numeric::columns::ends;
use crate::regression::confidence::Fade;
use crate::regression::rotations;
use crate::scattered::deviation::{F32_ERROR, Probe};
use crate::scattered::matrix;
use crate::scattered::model::{KernelModel, Output, OutputKind, features};
use crate::scattered::problem::{Mode, Problem, ProblemOptions};
use crate::scattered::solver::choose::Spacing;
use crate::scattered::solver::refusal::Refusal;
use crate::scattered::solver::samples::{ONE_SITE, check, ranges};
use crate::scattered::sum::KernelSum;
use faer::Mat;
use report::Fitted;
use sinew_runtime::kernel::{Normalise, QueryRule};
use solved::Data;

/// Factor of the fade's start. The f32 rounding of a squared distance then leaves the sample there at confidence 1.
const ROOM: f64 = 1.0 + 1e-4;

/// Kernels that an error suggests if the chosen kernel does not fit, the smoothest first.
const KERNELS: [&str; 3] = ["matern 5/2", "matern 3/2", "linear"];
/// Distance of two samples below which an error names them, over the mean distance between nearest samples.
const NEAR: f64 = 0.1;

/// Fits a problem.
///
/// - `variance`: whether the model keeps its variance.
///
/// # Errors
/// If a site or value is unusable, options exclude each other, a fit is refused, or the deviation of the file is above
/// the limit in the options.
pub fn train(problem: &Problem, variance: bool) -> Result<Trained, Error> {
    let mut outputs = problem.outputs.clone();
    let (features, values) = matrices(problem, &mut outputs)?;
    let options = &problem.options;
    let limit = options.f32_error.unwrap_or(F32_ERROR);
    if !(limit > 0.0 && limit.is_finite()) {
        return Err(Error::value(format!(
            "the f32 error is {limit}, expected a finite number above 0: a share of the values' range"
        )));
    }
    check(&features, &values)?;
    // Every site has features, so this error does not occur.
    let probe = Probe::new(&problem.inputs, &problem.sites, ranges(&values), limit)
        .map_err(|error| error.within(problem.place(0, "sites")))?;
    let of = Data { problem, features: &features, values: &values, probe: &probe };
    let (fitted, deviation) = of.fitted(variance).map_err(|error| of.advised(error))?;
    let Fitted { sum, variance: kept, figures, report, is_narrow, mut warnings } = fitted;
    if variance && kept.is_none() {
        return Err(Error::unsupported(
            "only a fit with every sample a centre has a variance: leave out `centres`, `learn` and `mode`",
        ));
    }
    if is_narrow {
        let other = of.other().map_or(String::new(), |other| format!("; {other} joins them"));
        warnings.push(format!(
            "single precision holds no width that joins these samples: between them the function falls off{other}"
        ));
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
    let default = if any { Normalise::Always } else { Normalise::Never };
    let query = options.outside.unwrap_or(QueryRule::Free);
    let model = KernelModel {
        name: problem.name.clone(),
        inputs: problem.inputs.clone(),
        fade: fade(&sum, &features, query)?,
        sum,
        ranges: features.col_iter().map(|column| ends(column.iter())).collect(),
        query,
        normalise: options.normalise.unwrap_or(default),
        outputs,
        variance: kept,
        fit: figures,
    };
    Ok(Trained { model, report, deviation, warnings })
}

impl Data<'_> {
    /// Fits the problem, and measures the deviation of its file.
    fn fitted(&self, variance: bool) -> Result<(Fitted, f64), Error> {
        let options = &self.problem.options;
        let fitted = match (options.mode, &options.learn) {
            (Mode::Sinew, None) => solved::fit(self, variance)?,
            (Mode::Sinew, Some(learn)) => modes::learned(self, learn)?,
            (Mode::Scipy, _) => modes::scipy(self)?,
            (Mode::Published, _) => modes::published(self)?,
        };
        let deviation = self.probe.check(&fitted.sum, |x| fitted.sum.evaluate(x))?;
        Ok((fitted, deviation))
    }

    /// Adds advice to an error: options that fit, and samples that are too near.
    fn advised(&self, error: Error) -> Error {
        match Refusal::of(&error) {
            Some(refusal @ Refusal::IllConditioned { .. }) => {
                refusal.advised(self.near(), self.other())
            }
            Some(refusal) => refusal.advised(None, self.other()),
            None => error,
        }
    }

    /// Finds options that fit: a lower degree, or another kernel at a width that joins the samples.
    ///
    /// Other solvers' modes and learned centres have no advice.
    fn other(&self) -> Option<String> {
        let own = &self.problem.options;
        if own.mode != Mode::Sinew || own.learn.is_some() {
            return None;
        }
        let degree = own.degree.unwrap_or(0);
        let lower = std::iter::successors(Some(degree / 2), |degree| Some(degree / 2));
        let lower = lower.take_while(|degree| *degree > 0).map(|degree| {
            let options = ProblemOptions { degree: Some(degree), ..own.clone() };
            (options, format!("degree {degree}"))
        });
        let kernels = KERNELS.into_iter().map(|kernel| {
            let name = Some(kernel.to_owned());
            let options =
                ProblemOptions { kernel: name, degree: None, epsilon: None, ..own.clone() };
            (options, format!("the kernel \"{kernel}\""))
        });
        let fits = |options: ProblemOptions| {
            let problem = Problem { options, ..self.problem.clone() };
            let fitted = Data { problem: &problem, ..*self }.fitted(false);
            fitted.is_ok_and(|(fitted, _)| !fitted.is_narrow)
        };
        lower.chain(kernels).find_map(|(options, name)| fits(options).then_some(name))
    }

    /// Names the two nearest samples, if they are much nearer than others.
    fn near(&self) -> Option<String> {
        let samples = solved::samples(self).ok()?;
        let Spacing { mean, least, nearest } = Spacing::new(&samples);
        let [first, second] = nearest.map(|sample| samples.rows[sample]);
        let rows = self.problem.rows(first, second);
        (least < NEAR * mean)
            .then(|| format!("{rows} are only {least:.1e} of the mean distance apart"))
    }
}

/// Chooses the fade: it starts at the largest distance of a sample from its nearest other centre.
///
/// A centre at the sample's own site does not count: such a centre is nearer than [`ONE_SITE`]. If there is no other
/// centre, any fade works, because every query is at the centre or fades within a width of the kernel.
///
/// # Errors
/// If there are no centres to fade by.
fn fade(sum: &KernelSum, features: &Mat<f64>, outside: QueryRule) -> Result<Fade, Error> {
    if sum.centres.ncols() == 0 {
        return match outside {
            QueryRule::Fade => Err(Error::unsupported(
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

/// Converts the rows of a problem into features of the sites (n x d) and values of the function (n x m), and sets the
/// neutral values of `outputs` from the neutral sample.
///
/// # Errors
/// If a site or value is unusable, or the neutral sample does not exist.
fn matrices(problem: &Problem, outputs: &mut [Output]) -> Result<(Mat<f64>, Mat<f64>), Error> {
    let site = |(row, site): (usize, &Vec<f64>)| {
        features(&problem.inputs, site).map_err(|error| error.within(problem.place(row, "sites")))
    };
    let sites = problem.sites.iter().enumerate().map(site).collect::<Result<Vec<_>, _>>()?;
    let (row, samples) = (problem.options.neutral, problem.values.len());
    let neutral = problem
        .values
        .get(row)
        .ok_or_else(|| Error::missing(format!("the neutral sample is row {row}, of {samples}")))?;
    let unusable = |error: Error, row: usize, output: &str| {
        let place = problem.place(row, "values");
        error.within(format_args!("{place}, output \"{output}\""))
    };
    let mut rest = neutral.as_slice();
    for Output { kind, name } in outputs.iter_mut() {
        let own;
        (own, rest) = rest.split_at(kind.number_len());
        match (kind, own) {
            (OutputKind::Scalar { neutral, .. }, &[x]) => *neutral = x,
            (OutputKind::Vector3 { neutral }, &[x, y, z]) => *neutral = [x, y, z],
            (OutputKind::Rotation { neutral }, &[x, y, z, w]) => {
                let length = (x * x + y * y + z * z + w * w).sqrt();
                // The loop below reports other quaternions that are no rotation.
                *neutral = [x, y, z, w].map(|part| part / length);
                if !length.is_normal() {
                    return Err(unusable(rotations::zero(), row, name));
                }
            }
            _ => {}
        }
    }
    let mut values = Vec::with_capacity(samples);
    for (row, numbers) in problem.values.iter().enumerate() {
        let (mut rest, mut out) = (numbers.as_slice(), Vec::new());
        for Output { kind, name } in outputs.iter() {
            let own;
            (own, rest) = rest.split_at(kind.number_len());
            out.extend(kind.to_values(own).map_err(|error| unusable(error, row, name))?);
        }
        values.push(out);
    }
    Ok((matrix(&sites), matrix(&values)))
}
