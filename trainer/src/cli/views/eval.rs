//! `sinew views eval` and `report`: comparison of a model with views.

use super::input::SetArguments;
use crate::cli::report::figure;
use crate::cli::{ModelArgs, OfFile, Output, OutputFile, Report, Run, load};
use crate::views::evaluate::evaluate;
use crate::views::report::report;
use std::path::PathBuf;

/// Measures a model on views: points, visibility and pictures
///
/// The command takes the views under `test`, or those under `train` if there are no test views. Points are in pixels,
/// visibility is the share of points with the right visibility, and pictures are in dB.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew views eval head.sinew demo/head/views.json")]
pub(in crate::cli) struct Eval {
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    set: SetArguments,
}

impl Run for Eval {
    fn run(&self, _: Output) -> anyhow::Result<Report> {
        let model = self.model.load()?;
        let set = self.set.read()?;
        let found = evaluate(&model, &set).of(&self.set.views)?;
        let views = if found.is_training { "views of the training" } else { "test views" };
        let mut report = Report::of(&found).show("views", views, "");
        report = match found.points {
            Some(_) => report
                .show("rms", "points, RMS", "px")
                .show("max", "points, most", "px")
                .show("visibility", "visibility", ""),
            None => report.text("points: not known"),
        };
        for (key, label, psnr) in [
            ("psnr", "PSNR, whole pictures", found.psnr),
            ("psnr_opaque", "PSNR, where opaque", found.psnr_opaque),
        ] {
            // An infinite PSNR is null in JSON.
            if let Some(psnr) = psnr {
                report = report.shown(key, label, psnr, format!("{} dB", figure(psnr)));
            }
        }
        Ok(report.show("flipped", "elements turned over", ""))
    }
}

/// Writes a page about a model and its training views
///
/// The page has a sheet of views by their parameters, with the training views framed. It shows the parts of a view,
/// networks over pixels, and the object that lent its motion.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  sinew views report head.sinew demo/head/views.json -o head.html"
)]
pub(in crate::cli) struct ReportArgs {
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    set: SetArguments,
    /// Model that lent MODEL its motion, trained on VIEWS; both objects are drawn side by side
    #[arg(long, value_name = "MODEL")]
    prototype: Option<PathBuf>,
    /// Page to write
    #[arg(short, long, alias = "out", value_name = "HTML")]
    output: PathBuf,
}

impl Run for ReportArgs {
    fn run(&self, _: Output) -> anyhow::Result<Report> {
        let file = self.set.views.as_path();
        let taken = [&*self.model.file, file].into_iter().chain(self.prototype.as_deref());
        let target = OutputFile::new(&self.output, taken)?.of_a_report()?;
        let (model, set) = (self.model.load()?, self.set.read()?);
        let prototype = self.prototype.as_deref().map(load).transpose()?;
        let page = report(&model, &set, prototype.as_ref()).of(file)?;
        Report::default().write(&target, page.as_bytes())
    }
}
