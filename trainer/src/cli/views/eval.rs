//! `sinew views eval`: a file against views.

use super::input::{SetArguments, load};
use crate::cli::Output;
use anyhow::Context;
use sinew_trainer::views::evaluate::evaluate;
use std::path::PathBuf;

/// Measures a model on views: points, visibility and pictures
///
/// It takes the views under `test`, or, where there are none, those under `train`. Points are in pixels, visibility is
/// the share of points for which it is right, pictures are in dB.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A file that `sinew views train` wrote
    model: PathBuf,
    #[command(flatten)]
    set: SetArguments,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
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
