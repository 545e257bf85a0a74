//! The commands of scattered data, by name.

use super::{check, eval, plot, train};
use crate::cli::Output;
use clap::Subcommand;

#[derive(Subcommand)]
pub(in crate::cli) enum Command {
    Train(train::Arguments),
    Eval(eval::Arguments),
    Check(check::Arguments),
    Plot(plot::Arguments),
}

impl Command {
    /// Does what it says.
    ///
    /// # Errors
    /// Bad input, or a file that cannot be written.
    pub(in crate::cli) fn run(&self, output: Output) -> anyhow::Result<()> {
        match self {
            Command::Train(arguments) => train::run(arguments, output),
            Command::Eval(arguments) => eval::run(arguments, output),
            Command::Check(arguments) => check::run(arguments, output),
            Command::Plot(arguments) => plot::run(arguments, output),
        }
    }
}
