//! `sinew demo`: the whole way on a character that needs no download.

use super::bars::Bars;
use super::{Output, input, print_json, table, train};
use anyhow::Context;
use serde_json::json;
use sinew_trainer::bake::write_atomically;
use sinew_trainer::demo::{DemoOptions, demo};
use sinew_trainer::envelope;
use sinew_trainer::evaluate::{Frames, evaluate};
use sinew_trainer::examples::{Split, npz};
use std::path::PathBuf;

/// Generates a procedural arm, trains an envelope on it, bakes it, and measures the baked model on
/// poses that the training has not seen.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Vertices of the arm, about
    #[arg(long, value_name = "V", default_value_t = DemoOptions::default().vertices)]
    vertices: usize,
    /// Training poses
    #[arg(long, value_name = "N", default_value_t = DemoOptions::default().poses)]
    poses: usize,
    /// Held-out poses
    #[arg(long, value_name = "N", default_value_t = DemoOptions::default().held_out)]
    held_out: usize,
    /// Seed of the poses
    #[arg(long, default_value_t = DemoOptions::default().seed)]
    seed: u64,
    #[command(flatten)]
    fit: train::FitArguments,
    /// Write the examples (demo.npz, demo.json) and the model (demo.sinew) to DIR
    #[arg(long, short = 'o', value_name = "DIR")]
    output: Option<PathBuf>,
}

pub(super) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let examples = demo(&DemoOptions {
        vertices: arguments.vertices,
        poses: arguments.poses,
        held_out: arguments.held_out,
        seed: arguments.seed,
    });
    let diagonal = examples.diagonal();
    let options = arguments.fit.options(diagonal)?;
    let trained = envelope::train(&examples, &options, &Bars::new(output))?;
    let evaluation = evaluate(&trained.model, &examples, Frames::Of(Split::HeldOut))?;
    if let Some(folder) = &arguments.output {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        npz::save_npz(&folder.join("demo.npz"), &examples)?;
        let model = folder.join("demo.sinew");
        write_atomically(&model, &trained.model)
            .with_context(|| format!("cannot write {}", model.display()))?;
    }
    if output.json {
        return print_json(&json!({ "report": trained.report, "evaluation": evaluation }));
    }
    println!("a procedural arm: {}", input::describe(&examples));
    table::print_report(&trained.report, diagonal, trained.proxies);
    table::print_evaluation(&evaluation);
    Ok(())
}
