//! `sinew kernel train`: from samples to a function in a file.

use crate::cli::files::{OutputFile, write};
use crate::cli::{Output, counted, printable};
use anyhow::Context;
use serde_json::json;
use sinew_runtime::format::Space;
use sinew_runtime::kernel::QueryRule;
use sinew_trainer::bake::bake;
use sinew_trainer::scattered::bake::part;
use sinew_trainer::scattered::problem::{ProblemOptions, Smoothing, read};
use sinew_trainer::scattered::solver::report::FitReport;
use sinew_trainer::scattered::train::{LearnReport, Report, Trained, train};
use std::path::PathBuf;

/// Turns samples into a function, and bakes it into a file
///
/// PROBLEM is JSON with `sites`, `values` and, where they are more than numbers, `inputs`, `outputs` and
/// `options`; or CSV, a sample a line below a line of names; or .npz with `sites` and `values`. What
/// is given here counts more than the options of the file.
#[derive(clap::Args)]
#[command(after_help = "\
Kinds of inputs: scalar, vector3, quaternion, rows, swing, twist, angle, and \"euler XYZ\" in any order \
(degrees); swing, twist and angle are about an `axis`. Kinds of outputs: scalar (with `clamp`: [least, \
most] and `normalise`), vector3, quaternion. Columns a.x a.y a.z of a CSV are one vector, with a.w one \
quaternion, a.rx a.ry a.rz one rotation.\n\
Without --epsilon the width is the one that predicts left-out samples best.")]
pub(in crate::cli) struct Arguments {
    /// Samples: .json, .csv or .npz
    problem: PathBuf,
    /// The file to write
    #[arg(short, long, value_name = "MODEL")]
    out: PathBuf,
    /// gaussian, thin plate, linear, cubic, quintic, multiquadric, inverse multiquadric, inverse
    /// quadratic, matern 1/2, 3/2 or 5/2, wendland [default: gaussian]
    #[arg(long)]
    kernel: Option<String>,
    /// One over the width, in mean distances of the samples
    #[arg(long)]
    epsilon: Option<f64>,
    /// Smooths instead of passing through every sample: a number, or auto; numbers, one a sample, as 0,0.1,0
    #[arg(long, value_parser = smoothing)]
    smoothing: Option<Smoothing>,
    /// Takes the mean of samples of one site that differ
    #[arg(long)]
    average: bool,
    /// Degree of the polynomial beside the kernels; -1 for none
    #[arg(long, allow_negative_numbers = true)]
    degree: Option<i32>,
    /// Fewer centres than samples
    #[arg(long)]
    centres: Option<usize>,
    /// Far from the samples: free, clamp (stay within their box) or fade (to the neutral sample)
    #[arg(long, value_parser = outside)]
    outside: Option<QueryRule>,
    /// Names of a CSV's outputs [default: the last]
    #[arg(long, value_delimiter = ',')]
    outputs: Vec<String>,
    /// How far the file may be off, at the samples and between them, over the values' range: single precision
    /// rounds [default: 0.001]
    #[arg(long, value_name = "SHARE")]
    f32_error: Option<f64>,
    /// Learns centres and the weight of each input
    #[arg(long)]
    learn: bool,
    /// Keeps what `eval --variance` takes
    #[arg(long)]
    variance: bool,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let Arguments { problem: path, out, .. } = arguments;
    let target = OutputFile::new(out, std::slice::from_ref(path))?.of_a_model()?;
    let about = || path.display().to_string();
    let mut problem = read(path, &arguments.outputs).with_context(about)?;
    overrule(&mut problem.options, arguments);
    let Trained { model, report, deviation, warnings } =
        train(&problem, arguments.variance).with_context(about)?;
    warnings.iter().for_each(|warning| output.warn(about(), printable(warning)));
    let bytes = bake(Space::default(), &[part(&model)?])?;
    write(&[(&target, &bytes)])?;
    let mut text = format!(
        "{}: {}, {} to {}, kernel {}\n",
        printable(&model.name),
        counted(problem.sites.len(), "sample", "samples"),
        counted(model.inputs.len(), "input", "inputs"),
        counted(model.outputs.len(), "output", "outputs"),
        model.sum.kernel.name(),
    );
    text += &match &report {
        Report::Fit(report) => of_fit(report),
        Report::Learned(report) => of_learned(report),
        Report::Mode { rcond, residual_rms } => {
            line("reciprocal condition", *rcond) + &line("left at the samples, RMS", *residual_rms)
        }
    };
    text += &line("f32 is off by, of the range", deviation);
    text += &format!("{}: {} bytes\n", target.named().display(), bytes.len());
    let json = json!({
        "bytes": bytes.len(), "report": report, "f32_error": deviation, "warnings": warnings,
    });
    output.print(&json, &text)
}

/// Puts what the command line says over what the file says.
fn overrule(own: &mut ProblemOptions, arguments: &Arguments) {
    own.kernel = arguments.kernel.clone().or(own.kernel.take());
    own.smoothing = arguments.smoothing.clone().or(own.smoothing.take());
    own.epsilon = arguments.epsilon.or(own.epsilon);
    own.degree = arguments.degree.or(own.degree);
    own.centres = arguments.centres.or(own.centres);
    own.outside = arguments.outside.unwrap_or(own.outside);
    own.f32_error = arguments.f32_error.unwrap_or(own.f32_error);
    own.average |= arguments.average;
    if arguments.learn && own.learn.is_none() {
        own.learn = Some(Default::default());
    }
}

/// Parses a smoothing: a number, numbers parted by commas, or auto.
fn smoothing(text: &str) -> Result<Smoothing, String> {
    if text == "auto" {
        return Ok(Smoothing::Chosen);
    }
    let numbers: Result<Vec<f64>, _> =
        text.split(',').map(|number| number.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[one]) => Ok(Smoothing::Given(one)),
        Ok(all) => Ok(Smoothing::Each(all.to_vec())),
        Err(_) => Err("expected a number, numbers (one a sample) or auto".to_owned()),
    }
}

/// Parses the name of a rule for queries outside the data.
fn outside(text: &str) -> Result<QueryRule, String> {
    let found = QueryRule::ALL.into_iter().find(|rule| rule.name() == text);
    found.ok_or_else(|| "expected free, clamp or fade".to_owned())
}

fn line(name: &str, value: f64) -> String {
    format!("{name:<36}{value:>12.3e}\n")
}

fn of_fit(report: &FitReport) -> String {
    let mut out = line("width, in mean distances", 1.0 / report.epsilon);
    if report.smoothing > 0.0 {
        out += &line("smoothing", report.smoothing);
        out += &line("degrees of freedom", report.freedom);
    }
    out += &line("left at the samples, RMS", report.residual_rms);
    out += &match report.left_out_rms {
        Some(rms) => line("samples left out, RMS error", rms),
        None => "samples left out                     too few to tell\n".to_owned(),
    };
    out += &line("reciprocal condition", report.rcond);
    out + &line("f32 may be off by, at worst", report.bounds.iter().copied().fold(0.0, f64::max))
}

fn of_learned(report: &LearnReport) -> String {
    let mut out = line("left at the samples, RMS", report.residual_rms);
    out += &line("f32 may be off by, at worst", report.bound);
    for (feature, weight) in report.relevance.iter().enumerate() {
        out += &line(&format!("weight of feature {feature}"), *weight);
    }
    out
}
