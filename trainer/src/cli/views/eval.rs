//! `sinew views eval` and `report`: comparison of a model with views.

use super::input::{SetArguments, load};
use crate::cli::Output;
use crate::cli::files::{OutputFile, write};
use anyhow::Context;
use serde_json::json;
use sinew_trainer::views::evaluate::evaluate;
use sinew_trainer::views::report::report;
use std::path::PathBuf;

/// Measures a model on views: points, visibility and pictures
///
/// The command takes the views under `test`, or those under `train` if there are no test views. Points are in pixels,
/// visibility is the share of points with the right visibility, and pictures are in dB.
#[derive(clap::Args)]
pub(in crate::cli) struct Eval {
    /// A file that `sinew views train` wrote
    model: PathBuf,
    #[command(flatten)]
    set: SetArguments,
}

pub(in crate::cli) fn eval(arguments: &Eval, output: Output) -> anyhow::Result<()> {
    let model = load(&arguments.model)?;
    let set = arguments.set.read()?;
    let found =
        evaluate(&model, &set).with_context(|| arguments.set.file().display().to_string())?;
    let line = |name: &str, value: f64, unit: &str| format!("{name:<24}{value:>10.4}{unit}\n");
    let views = if found.is_training { "views of the training" } else { "test views" };
    let mut text = format!("{views:<24}{:>10}\n", found.views);
    text += &match &found.points {
        Some(points) => {
            line("points, RMS", points.rms, " px")
                + &line("points, most", points.max, " px")
                + &line("visibility", points.visibility, "")
        }
        None => format!("{:<24}{:>10}\n", "points", "not known"),
    };
    let pictures =
        [("PSNR, whole pictures", found.psnr), ("PSNR, where opaque", found.psnr_opaque)];
    for (name, psnr) in pictures {
        text += &psnr.map_or_else(String::new, |psnr| line(name, psnr, " dB"));
    }
    text += &format!("{:<24}{:>10}\n", "elements turned over", found.flipped);
    output.print(&found, &text)
}

/// Writes a page about a model and its training views
///
/// The page has a sheet of views by their parameters, with the training views framed. It shows the parts of a view,
/// networks over pixels, and the object that lent its motion.
#[derive(clap::Args)]
pub(in crate::cli) struct Report {
    /// A file that `sinew views train` wrote
    model: PathBuf,
    #[command(flatten)]
    set: SetArguments,
    /// The file that lent MODEL its motion, trained on VIEWS; both objects are drawn side by side
    #[arg(long, value_name = "MODEL")]
    prototype: Option<PathBuf>,
    /// The page to write, HTML
    #[arg(short, long, value_name = "HTML")]
    out: PathBuf,
}

pub(in crate::cli) fn write_report(arguments: &Report, output: Output) -> anyhow::Result<()> {
    let file = arguments.set.file();
    let mut taken = vec![arguments.model.clone(), file.to_owned()];
    taken.extend(arguments.prototype.clone());
    let target = OutputFile::new(&arguments.out, &taken)?.of_a_report()?;
    let (model, set) = (load(&arguments.model)?, arguments.set.read()?);
    let prototype = arguments.prototype.as_deref().map(load).transpose()?;
    let page = report(&model, &set, prototype.as_ref());
    let page = page.with_context(|| file.display().to_string())?;
    write(&[(&target, page.as_bytes())])?;
    let text = format!("{}: {} bytes\n", target.named().display(), page.len());
    output.print(&json!({ "bytes": page.len() }), &text)
}
