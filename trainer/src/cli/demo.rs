//! `sinew demo`: the whole way on a character that needs no download.

use super::bars::Bars;
use super::files::{self, Target};
use super::{Output, input, table, train};
use anyhow::{Context, bail};
use clap::builder::RangedU64ValueParser;
use serde_json::json;
use sinew_trainer::demo::{DemoOptions, demo};
use sinew_trainer::evaluate::{Frames, evaluate};
use sinew_trainer::examples::{Split, npz};
use std::path::{Path, PathBuf};

/// Most positions in all frames together: 2.4 GB of them.
const POSITIONS_MAX: usize = 100_000_000;

/// Generates a procedural arm, trains an envelope on it, bakes it, and measures the baked model on
/// poses that the training has not seen.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Vertices of the arm, about; at least 200 are made
    #[arg(long, value_name = "V", value_parser = some())]
    #[arg(default_value_t = DemoOptions::default().vertices)]
    vertices: usize,
    /// Training poses
    #[arg(long, value_name = "N", value_parser = some())]
    #[arg(default_value_t = DemoOptions::default().poses)]
    poses: usize,
    /// Held-out poses
    #[arg(long, value_name = "N", value_parser = some())]
    #[arg(default_value_t = DemoOptions::default().held_out)]
    held_out: usize,
    /// Seed of the poses
    #[arg(long, default_value_t = DemoOptions::default().seed)]
    seed: u64,
    #[command(flatten)]
    fit: train::FitArguments,
    /// Write the examples (demo.npz, demo.json) and the model (demo.sinew) to DIR, which is made
    /// if it is not there
    #[arg(long, short = 'o', value_name = "DIR")]
    output: Option<PathBuf>,
}

fn some() -> RangedU64ValueParser<usize> {
    RangedU64ValueParser::new().range(1..=POSITIONS_MAX as u64)
}

pub(super) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let &Arguments { vertices, poses, held_out, seed, .. } = arguments;
    let positions = (poses + held_out).checked_mul(vertices);
    if positions.is_none_or(|positions| positions > POSITIONS_MAX) {
        bail!("--vertices x (--poses + --held-out): expected at most {POSITIONS_MAX}");
    }
    let folder = arguments.output.as_deref();
    let model = folder.map(prepare).transpose()?;
    let generating = Bars::busy(output, "generating");
    let examples = demo(&DemoOptions { vertices, poses, held_out, seed });
    drop(generating);
    let trained = arguments.fit.train(&examples, "demo", output)?;
    let measuring = Bars::busy(output, "measuring");
    let evaluation = evaluate(&trained.model, &examples, Frames::Of(Split::HeldOut))?;
    drop(measuring);
    let mut text = format!(
        "a procedural arm: {}\n{}{}",
        input::describe(&examples),
        table::report(&trained.report),
        table::evaluation(&evaluation)
    );
    if let (Some(folder), Some(model)) = (folder, &model) {
        npz::save_npz(&folder.join("demo.npz"), &examples)?;
        files::write(&[(model, &trained.model)])?;
        text += &format!("wrote demo.npz, demo.json and demo.sinew to {}\n", folder.display());
    }
    output.print(&json!({ "report": trained.report, "evaluation": evaluation }), &text)
}

/// Makes the folder, tries the places of its three files, and gives that of the model.
fn prepare(folder: &Path) -> anyhow::Result<Target> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    for examples in ["demo.npz", "demo.json"] {
        Target::new(&folder.join(examples), &[])?;
    }
    Target::new(&folder.join("demo.sinew"), &[])
}
