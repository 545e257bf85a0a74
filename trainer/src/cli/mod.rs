//! The command line: one file a subcommand.

mod bars;
mod demo;
mod eval;
mod input;
mod inspect;
mod table;
mod train;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Learns how a character's skin moves from example poses, bakes it into a small file, and measures
/// that file against linear blend skinning (LBS).
#[derive(Parser)]
#[command(name = "sinew", version, arg_required_else_help = true)]
#[command(after_help = "Start with `sinew demo`: it needs no input.")]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    output: Output,
}

/// What goes to the terminal.
#[derive(clap::Args, Clone, Copy)]
struct Output {
    /// No progress, no warnings: results and errors alone
    #[arg(long, short, global = true)]
    quiet: bool,
    /// Results as one JSON object on standard output
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Trains, bakes and evaluates a procedural arm
    Demo(demo::Arguments),
    /// Trains a model on example poses
    Train(train::Arguments),
    /// Measures a model against examples, with LBS beside it
    Eval(eval::Arguments),
    /// Shows what a model file holds
    Inspect(inspect::Arguments),
}

pub(crate) fn main() -> ExitCode {
    let cli = Cli::parse();
    let done = match &cli.command {
        Command::Demo(arguments) => demo::run(arguments, cli.output),
        Command::Train(arguments) => train::run(arguments, cli.output),
        Command::Eval(arguments) => eval::run(arguments, cli.output),
        Command::Inspect(arguments) => inspect::run(arguments, cli.output),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("sinew: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Prints a result as JSON.
fn print_json(value: &impl serde::Serialize) -> anyhow::Result<()> {
    println!("{}", serde_json::to_string_pretty(value)?);
    Ok(())
}
