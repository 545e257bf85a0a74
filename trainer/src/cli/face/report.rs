//! `sinew face report`: a page that shows what a prior does.

use super::eval::{Measured, measure};
use super::input;
use crate::cli::Output;
use crate::cli::files::{OutputFile, write};
use anyhow::Context;
use sinew_trainer::face::outline::{self, Outline};
use sinew_trainer::face::picture::Photographer;
use sinew_trainer::face::report::Report;
use std::path::PathBuf;

/// Writes a page that shows how near a few handles bring a face
///
/// The page shows expressions of a take by a few handles, with the prior and with the slider norm side by side, where
/// each is off, and a drag. It is one HTML file.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    measured: Measured,
    /// The page to write
    #[arg(short, long, value_name = "PAGE")]
    out: PathBuf,
    /// Pixels in a row of a picture
    #[arg(long, default_value_t = 380, value_parser = clap::value_parser!(u32).range(16..=4096))]
    width: u32,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let Arguments { measured, out, width } = arguments;
    let (path, take) = (&measured.face, &measured.animation);
    let target = OutputFile::new(out, &[path.clone(), outline::beside(path), take.clone()])?
        .of_a_report()?;
    let model = input::load(path)?;
    let face = input::open(&model, path)?;
    let outline = Outline::read(path, face.skin.vertex_len())?;
    let about = || path.display().to_string();
    let mesh = outline.faces().with_context(about)?;
    let space = model.space();
    let html = measure(measured, output, |protocol, evaluation| {
        let vertices = protocol.vertices.clone();
        let photographer =
            Photographer::new(&protocol.face, &space, mesh, vertices, *width as usize);
        let take = take.file_name().unwrap_or_default().to_string_lossy();
        let report = Report { protocol, evaluation, photographer: &photographer, take: &take };
        Ok((report.html().with_context(about)?, evaluation.clone()))
    });
    let (html, evaluation) = html?;
    write(&[(&target, html.as_bytes())])?;
    let text = format!("wrote {} ({} bytes)\n", target.named().display(), html.len());
    output.print(&evaluation, &text)
}
