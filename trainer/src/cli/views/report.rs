//! `sinew views report`: a page to look at.

use super::input::{SetArguments, load};
use crate::cli::Output;
use crate::cli::files::{OutputFile, write};
use anyhow::Context;
use serde_json::json;
use sinew_trainer::views::report::report;
use std::path::PathBuf;

/// Writes a page about MODEL and the views that it was trained on: a sheet of views by their parameters, the examples framed,
/// what a view is made of, and the network over pixels beside it.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A file that `sinew views train` wrote
    model: PathBuf,
    #[command(flatten)]
    set: SetArguments,
    /// The page to write, HTML
    #[arg(short, long, value_name = "HTML")]
    out: PathBuf,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let file = arguments.set.file();
    let taken = [arguments.model.clone(), file.to_owned()];
    let target = OutputFile::new(&arguments.out, &taken)?;
    let (model, set) = (load(&arguments.model)?, arguments.set.read()?);
    let page = report(&model, &set).with_context(|| file.display().to_string())?;
    write(&[(&target, page.as_bytes())])?;
    let text = format!("{}: {} bytes\n", target.named().display(), page.len());
    output.print(&json!({ "bytes": page.len() }), &text)
}
