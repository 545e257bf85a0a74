//! `sinew kernel train`: from samples to a function in a file.

use crate::bake::bake;
use crate::cli::{OfFile, Output, OutputFile, Report, Run, named, printable};
use crate::scattered::bake::part;
use crate::scattered::problem::{ProblemOptions, Smoothing, read};
use crate::scattered::train::{self, Trained};
use sinew_runtime::format::Space;
use sinew_runtime::kernel::QueryRule;
use std::path::PathBuf;

/// Turns samples into a function, and bakes it into a file
///
/// PROBLEM is JSON with `sites`, `values` and, for inputs and outputs other than numbers, `inputs`, `outputs` and
/// `options`; or CSV, a line of names and a line for each sample; or .npz with `sites` and `values`. Options given here
/// replace the options of the file.
#[derive(clap::Args)]
#[command(after_help = "\
Kinds of inputs: scalar, vector3, quaternion, rows, swing, twist, angle, and \"euler XYZ\" in any order \
(degrees); swing, twist and angle are about an `axis`. Kinds of outputs: scalar (with `clamp`: [least, \
most] and `normalise`), vector3, quaternion. Columns a.x a.y a.z of a CSV are one vector, with a.w one \
quaternion, a.rx a.ry a.rz one rotation.\n\n\
Example:\n  sinew kernel train wrist.json -o wrist.sinew")]
pub(in crate::cli) struct Train {
    /// Samples: .json, .csv or .npz
    problem: PathBuf,
    /// File to write
    #[arg(short, long, alias = "out", value_name = "MODEL")]
    output: PathBuf,
    /// Names of a CSV's outputs [default: the last]
    #[arg(long, value_delimiter = ',')]
    outputs: Vec<String>,
    /// Keep the data of `eval --variance`
    #[arg(long)]
    variance: bool,
    /// Allowed error of the file's single precision, as a share of the values' range [default: 0.001]
    #[arg(long, value_name = "SHARE")]
    f32_error: Option<f64>,
    #[command(flatten)]
    fit: FitArgs,
}

/// Options of the fit.
#[derive(clap::Args)]
#[command(next_help_heading = "Fit")]
struct FitArgs {
    /// gaussian, thin plate, linear, cubic, quintic, multiquadric, inverse multiquadric, inverse quadratic, matern 1/2,
    /// 3/2 or 5/2, wendland [default: gaussian]
    #[arg(long)]
    kernel: Option<String>,
    /// One over the width, in mean distances of the samples [default: the best prediction of left-out samples]
    #[arg(long)]
    epsilon: Option<f64>,
    /// Smooth, and do not pass through every sample: a number, auto, or a number for each sample, as 0,0.1,0
    #[arg(long, value_parser = smoothing)]
    smoothing: Option<Smoothing>,
    /// Take the mean of different samples at one site
    #[arg(long)]
    average: bool,
    /// Degree of the polynomial beside the kernels; -1 for none
    #[arg(long, allow_negative_numbers = true)]
    degree: Option<i32>,
    /// Number of centres, fewer than samples
    #[arg(long)]
    centres: Option<usize>,
    /// Behaviour far from the samples: clamp stays within their box, fade approaches the neutral sample
    #[arg(long, value_parser = named(QueryRule::ALL.map(|rule| (rule.name(), rule))))]
    outside: Option<QueryRule>,
    /// Learn centres and the weight of each input
    #[arg(long)]
    learn: bool,
}

impl Run for Train {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        let path = &self.problem;
        let target = OutputFile::new(&self.output, [path])?.of_a_model()?;
        let mut problem = read(path, &self.outputs).of(path)?;
        self.overrule(&mut problem.options);
        let Trained { model, report, deviation, warnings } =
            train::train(&problem, self.variance).of(path)?;
        warnings.iter().for_each(|warning| output.warn(path.display(), printable(warning)));
        let bytes = bake(Space::default(), &[part(&model)?])?;
        Report::default()
            .figure("name", "function", &model.name, "")
            .figure("samples", "samples", problem.sites.len(), "")
            .figure("inputs", "inputs", model.inputs.len(), "")
            .figure("outputs", "outputs", model.outputs.len(), "")
            .figure("kernel", "kernel", model.sum.kernel.name(), "")
            .part("report", of_fit(&report))
            .figure("f32_error", "error of f32, share of the range", deviation, "")
            .json("warnings", warnings)
            .write(&target, &bytes)
    }
}

/// Returns the figures of a fit, under the name of its method.
fn of_fit(report: &train::Report) -> Report {
    let (method, fit) = match report {
        train::Report::Fit(own) => {
            let fit = Report::of(own)
                .show("epsilon", "epsilon (1 / width in mean distances)", "")
                .show("smoothing", "smoothing", "")
                .show("freedom", "degrees of freedom", "")
                .show("left_out_rms", "samples left out, RMS error", "");
            let fit = match own.left_out_rms {
                Some(_) => fit,
                None => fit.text("samples left out: too few to measure"),
            };
            let bound = own.bounds.iter().copied().fold(0.0, f64::max);
            ("fit", fit.figure("", "error of f32, bound", bound, ""))
        }
        train::Report::Learned(own) => {
            let fit = Report::of(own).show("bound", "error of f32, bound", "");
            ("learned", fit.show("relevance", "weights of the features", ""))
        }
        train::Report::Mode { rcond, residual_rms } => {
            ("mode", Report::default().json("rcond", rcond).json("residual_rms", residual_rms))
        }
    };
    let fit = fit.show("residual_rms", "error at the samples, RMS", "");
    Report::default().part(method, fit.show("rcond", "reciprocal condition", ""))
}

impl Train {
    /// Replaces options of the file by options of the command line.
    fn overrule(&self, own: &mut ProblemOptions) {
        let arguments = &self.fit;
        own.kernel = arguments.kernel.clone().or(own.kernel.take());
        own.smoothing = arguments.smoothing.clone().or(own.smoothing.take());
        own.epsilon = arguments.epsilon.or(own.epsilon);
        own.degree = arguments.degree.or(own.degree);
        own.centres = arguments.centres.or(own.centres);
        own.outside = arguments.outside.or(own.outside);
        own.f32_error = self.f32_error.or(own.f32_error);
        own.average |= arguments.average;
        if arguments.learn && own.learn.is_none() {
            own.learn = Some(Default::default());
        }
    }
}

/// Parses a smoothing: a number, numbers separated by commas, or auto.
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
