//! The command that was given.

use super::envelope::{check, demo, eval, export, export_demo, inspect, report, train};
use super::output::{Output, in_a_line, tell};
use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Learns how a character's skin moves from example poses, bakes it into a small file, and measures
/// that file against linear blend skinning (LBS).
#[derive(Parser)]
#[command(name = "sinew", version, arg_required_else_help = true)]
#[command(after_help = "Start with `sinew demo`: it needs no input.\n\
    Exit status: 0 done, 1 failed (bad input, or a file that cannot be written), 2 bad usage.")]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    output: Output,
}

#[derive(Subcommand)]
enum Command {
    Demo(demo::Arguments),
    Check(check::Arguments),
    Train(train::Arguments),
    Eval(eval::Arguments),
    Inspect(inspect::Arguments),
    Report(report::Arguments),
    Export(export::Arguments),
    ExportDemo(export_demo::Arguments),
}

pub(crate) fn main() -> ExitCode {
    let cli = Cli::parse();
    let done = match &cli.command {
        Command::Demo(arguments) => demo::run(arguments, cli.output),
        Command::Check(arguments) => check::run(arguments, cli.output),
        Command::Train(arguments) => train::run(arguments, cli.output),
        Command::Eval(arguments) => eval::run(arguments, cli.output),
        Command::Inspect(arguments) => inspect::run(arguments, cli.output),
        Command::Report(arguments) => report::run(arguments, cli.output),
        Command::Export(arguments) => export::run(arguments, cli.output),
        Command::ExportDemo(arguments) => export_demo::run(arguments, cli.output),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tell(&in_a_line(&error));
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_well_formed() {
        Cli::command().debug_assert();
    }
}
