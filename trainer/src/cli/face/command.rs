//! The commands of faces, by name.

use super::{eval, pin, report, solve, train};
use crate::cli::Output;
use clap::Subcommand;

#[derive(Subcommand)]
pub(in crate::cli) enum Command {
    Train(train::Arguments),
    Pin(pin::Arguments),
    Solve(solve::Arguments),
    Eval(eval::Arguments),
    Report(report::Arguments),
}

impl Command {
    /// Does what it says.
    ///
    /// # Errors
    /// Bad input, or a file that cannot be written.
    pub(in crate::cli) fn run(&self, output: Output) -> anyhow::Result<()> {
        match self {
            Command::Train(arguments) => train::run(arguments, output),
            Command::Pin(arguments) => pin::run(arguments, output),
            Command::Solve(arguments) => solve::run(arguments, output),
            Command::Eval(arguments) => eval::run(arguments, output),
            Command::Report(arguments) => report::run(arguments, output),
        }
    }
}
