//! `sinew signal fit`: from values, derivatives and averages of one function to the function, in a file.

use crate::cli::files::{OutputFile, write};
use crate::cli::{Output, counted, printable};
use anyhow::Context;
use serde_json::json;
use sinew_runtime::format::Space;
use sinew_trainer::bake::bake;
use sinew_trainer::scattered::bake::part;
use sinew_trainer::signal::observations::Observations;
use sinew_trainer::signal::observations::function;
use std::path::PathBuf;

/// Finds a function from values, derivatives and averages
///
/// It is the likeliest function of one number. It is baked as a kernel, which `sinew kernel eval` and the runtime
/// evaluate.
///
/// OBSERVATIONS is JSON: `observations`, each {"at": x, "value": y}, {"at": x, "derivative": y} or {"from": a, "to": b,
/// "average": y}; and, as far as they are given, `name`, `covariance` ("squared exponential:LENGTH" and others; else
/// the likeliest), `mean` (zero, constant, linear), `noise`, `variance` and `f32_error`.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// What was observed: .json
    observations: PathBuf,
    /// The file to write
    #[arg(short, long, value_name = "MODEL")]
    out: PathBuf,
    /// How far the file may be off, where the function was observed and between, over the function's range: single
    /// precision rounds [default: 0.001]
    #[arg(long, value_name = "SHARE")]
    f32_error: Option<f64>,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let path = &arguments.observations;
    let target = OutputFile::new(&arguments.out, std::slice::from_ref(path))?.of_a_model()?;
    let about = || path.display().to_string();
    let observations = Observations::read(path, arguments.f32_error).with_context(about)?;
    let fit = observations.fit().with_context(about)?;
    let (model, deviation) = function(&observations, &fit).with_context(about)?;
    let bytes = bake(Space::default(), &[part(&model)?])?;
    write(&[(&target, &bytes)])?;
    let repeated = observations.repeated;
    if repeated > 0 {
        let what = format!(
            "observations that repeat earlier ones, or follow from them, and are left out: {repeated}"
        );
        output.warn(about(), what);
    }
    let (covariance, variance) =
        (observations.process.covariance.describe(), observations.variance(&fit));
    let (figures, centres) = (model.fit, model.sum.centres.ncols());
    let text = format!(
        "{}: {}, covariance {covariance}, deviation {:.4}; {}\n\
         left at the observations, RMS       {:>12.3e}\n\
         f32 may be off by, at worst         {:>12.3e}\n\
         f32 is off by, of the range         {deviation:>12.3e}\n\
         {}: {} bytes\n",
        printable(&model.name),
        counted(observations.values.len(), "observation", "observations"),
        variance.sqrt(),
        counted(centres, "centre", "centres"),
        figures.residual_rms,
        figures.bound,
        target.named().display(),
        bytes.len()
    );
    let json = json!({
        "bytes": bytes.len(),
        "observations": observations.values.len(),
        "covariance": covariance,
        "variance": variance,
        "centres": centres,
        "residual_rms": figures.residual_rms,
        "bound": figures.bound,
        "f32_error": deviation,
    });
    output.print(&json, &text)
}
