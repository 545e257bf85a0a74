//! Fits by METHOD §2, with every sample a centre or with fewer centres.

use super::report::{Fitted, Report};
use crate::Error;
use crate::regression::function::{is_scale_invariant, order};
use crate::scattered::deviation::Probe;
use crate::scattered::model::Figures;
use crate::scattered::problem::{Problem, ProblemOptions, Smoothing};
use crate::scattered::solver::choose::{Choice, Freedom};
use crate::scattered::solver::fit::Fit;
use crate::scattered::solver::options::{Options, wendland};
use crate::scattered::solver::report::FitReport;
use crate::scattered::solver::samples::{Conflicts, Samples, same_site};
use crate::scattered::solver::scaling::Block;
use faer::Mat;
use sinew_runtime::kernel::Kernel;

/// Arguments of a fit.
pub(super) struct Data<'a> {
    pub(super) problem: &'a Problem,
    pub(super) features: &'a Mat<f64>,
    pub(super) values: &'a Mat<f64>,
    pub(super) probe: &'a Probe,
}

/// Returns the error of a function that no file can hold.
pub(super) fn neighbours() -> Error {
    Error::unsupported(
        "a function of neighbours solves a system at every query and cannot be baked: take fewer `centres`",
    )
}

/// Fits a problem.
pub(super) fn fit(of: &Data<'_>, variance: bool) -> Result<Fitted, Error> {
    let own = &of.problem.options;
    if own.neighbors.is_some() {
        return Err(neighbours());
    }
    let mut samples = samples(of)?;
    let asked = asked(own, samples.scaling.kept().len())?;
    if let Some(Smoothing::Each(all)) = &own.smoothing {
        if own.centres.is_some() {
            return Err(Error::unsupported(
                "a smoothing for each sample is for a fit with every sample a centre: leave out `centres`",
            ));
        }
        samples.smoothing = each(all, &samples)?;
    }
    let freedom = Freedom {
        epsilon: own.epsilon.is_none() && !is_scale_invariant(asked.kernel),
        smoothing: matches!(own.smoothing, Some(Smoothing::Chosen)),
    };
    let (options, is_narrow) = if freedom.epsilon || freedom.smoothing {
        let groups = groups(own, &samples)?;
        let choice = Choice::new(&samples, &asked, freedom, &groups, Some(of.probe))?;
        (choice.options, choice.is_narrow)
    } else {
        (asked, false)
    };
    let fit = Fit::new(&samples, &options)?;
    let report = FitReport::new(&samples, &options, &fit);
    let kept = variance.then(|| fit.variance(&samples.values)).flatten();
    let figures = Figures {
        residual_rms: report.residual_rms,
        left_out_rms: report.left_out_rms.unwrap_or(0.0),
        bound: report.bounds.iter().copied().fold(0.0, f64::max),
        rcond: report.rcond,
    };
    let warnings = warnings(of.problem, &report);
    let report = Report::Fit(Box::new(report));
    Ok(Fitted { sum: fit.sum, variance: kept, figures, report, is_narrow, warnings })
}

/// Returns the smoothing of each sample from the smoothings of the rows. A sample of several rows has the smoothing of
/// the first row.
fn each(all: &[f64], samples: &Samples) -> Result<Vec<f64>, Error> {
    check_rows(samples, "smoothing", all.len())?;
    match all.iter().position(|lambda| !(*lambda >= 0.0 && lambda.is_finite())) {
        Some(row) => Err(Error::value(format!(
            "the smoothing of row {row} is {}, expected a finite number that is not negative",
            all[row]
        ))),
        None => Ok(samples.rows.iter().map(|&row| all[row]).collect()),
    }
}

/// Checks that something was given for every row.
fn check_rows(samples: &Samples, what: &str, found: usize) -> Result<(), Error> {
    let rows = samples.sample_len() + samples.merged.len();
    if found == rows {
        return Ok(());
    }
    let message = format!("expected a {what} for each of {rows} samples, found {found}");
    Err(Error::mismatch(message))
}

/// Collects the samples, with a block of columns for each input.
pub(super) fn samples(of: &Data<'_>) -> Result<Samples, Error> {
    let problem = of.problem;
    let inputs = problem.inputs.iter();
    let blocks: Vec<Block> =
        inputs.map(|input| Block { len: input.kind.feature_len(), weight: input.weight }).collect();
    let is_smoothed = match &problem.options.smoothing {
        None => false,
        Some(Smoothing::Given(smoothing)) => *smoothing > 0.0,
        Some(Smoothing::Each(all)) => all.iter().any(|smoothing| *smoothing > 0.0),
        Some(Smoothing::Chosen) => true,
    };
    let conflicts = match (problem.options.average, is_smoothed) {
        (true, _) => Conflicts::Average,
        (false, true) => Conflicts::Keep,
        (false, false) => Conflicts::Refuse,
    };
    Samples::refusing(of.features, of.values, &blocks, conflicts, |[first, second], distance| {
        let (rows, how) = (problem.rows(first, second), same_site(distance));
        Error::mismatch(format!(
            "{rows} have {how} and different values: take their mean (\"average\": true or --average), smooth \
             (--smoothing auto), or take one of them away"
        ))
    })
}

fn asked(own: &ProblemOptions, inputs: usize) -> Result<Options, Error> {
    let kernel = kernel(own.kernel.as_deref().unwrap_or("gaussian"), inputs)?;
    let mut out = Options::new(kernel);
    if let Some(degree) = own.degree {
        out.degree = degree_of(degree)?;
    }
    out.epsilon = own.epsilon.unwrap_or(out.epsilon);
    if let Some(Smoothing::Given(smoothing)) = own.smoothing {
        out.smoothing = smoothing;
    }
    out.centres = own.centres;
    Ok(out)
}

/// Reads a degree; -1 gives `None`.
pub(super) fn degree_of(degree: i32) -> Result<Option<usize>, Error> {
    if degree < -1 {
        let message = format!("the degree is {degree}, expected -1 (no polynomial) or more");
        return Err(Error::value(message));
    }
    Ok(usize::try_from(degree).ok())
}

/// Finds a kernel by its name, in upper or lower case, with spaces, `_` or nothing between the words.
pub(super) fn kernel(name: &str, inputs: usize) -> Result<Kernel, Error> {
    let plain = |text: &str| -> String {
        let text = text.to_lowercase().replace('é', "e");
        text.chars().filter(|c| c.is_alphanumeric()).collect()
    };
    let names = [("thinplatespline", Kernel::ThinPlate), ("exponential", Kernel::Matern12)];
    let own = Kernel::ALL.into_iter().filter(|kernel| order(*kernel).is_some());
    let known = own.map(|kernel| (plain(kernel.name()), kernel));
    let mut all = known.chain(names.map(|(name, kernel)| (name.to_owned(), kernel)));
    match all.find(|(known, _)| *known == plain(name)) {
        Some((_, Kernel::Wendland { .. })) => {
            let none = format!("there is no Wendland kernel for {inputs} features: take another");
            wendland(inputs).ok_or_else(|| Error::unsupported(none))
        }
        Some((_, kernel)) => Ok(kernel),
        None => {
            let own = Kernel::ALL.into_iter().filter(|kernel| order(*kernel).is_some());
            let expected = own.map(Kernel::name).collect::<Vec<_>>().join(", ");
            Err(Error::value(format!("\"{name}\" is no kernel: expected one of {expected}")))
        }
    }
}

/// Lists the groups of samples that are left out together: single samples, or the groups of the options.
fn groups(own: &ProblemOptions, samples: &Samples) -> Result<Vec<Vec<usize>>, Error> {
    let n = samples.sample_len();
    let Some(of_rows) = &own.groups else {
        return Ok((0..n).map(|sample| vec![sample]).collect());
    };
    check_rows(samples, "group", of_rows.len())?;
    let mut out = std::collections::BTreeMap::<usize, Vec<usize>>::new();
    for (sample, &row) in samples.rows.iter().enumerate() {
        out.entry(of_rows[row]).or_default().push(sample);
    }
    Ok(out.into_values().collect())
}

/// Lists warnings of merged samples, ignored inputs and a lowered degree.
fn warnings(problem: &Problem, report: &FitReport) -> Vec<String> {
    let mut out = Vec::new();
    for merged in &report.merged {
        let how = if merged.averaged { "averaged with" } else { "the same sample as" };
        let [row, into] = [merged.row, merged.into].map(|row| problem.row(row));
        out.push(format!("{row} is {how} {into}"));
    }
    let mut first = 0;
    for input in &problem.inputs {
        let own = first..first + input.kind.feature_len();
        first = own.end;
        if own.clone().all(|feature| report.dropped.contains(&feature)) {
            out.push(format!(
                "input \"{}\" is the same in all samples and does not count",
                input.name
            ));
        }
    }
    if report.degree != report.degree_asked {
        let degree = |degree: Option<usize>| degree.map_or("none".to_owned(), |d| d.to_string());
        let (asked, taken) = (degree(report.degree_asked), degree(report.degree));
        out.push(format!("too few samples for a polynomial of degree {asked}: taken is {taken}"));
    }
    out
}
