//! `sinew views report`: a page to look at.

use super::input::{SetArguments, load};
use crate::cli::Output;
use crate::cli::files::{OutputFile, write};
use anyhow::Context;
use serde_json::json;
use sinew_trainer::views::report::report;
use std::path::PathBuf;

/// Writes a page about a model and the views it was trained on
///
/// The page has a sheet of views by their parameters, with the examples framed. It shows the parts of a view, the
/// network over pixels beside it, and the object that lent its motion.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A file that `sinew views train` wrote
    model: PathBuf,
    #[command(flatten)]
    set: SetArguments,
    /// The file that lent MODEL its motion, and was trained on VIEWS: both are shown side by side
    #[arg(long, value_name = "MODEL")]
    prototype: Option<PathBuf>,
    /// The page to write, HTML
    #[arg(short, long, value_name = "HTML")]
    out: PathBuf,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
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
