//! The commands of signals, by name.

use super::{fit, plot, superres, train};
use crate::cli::Output;
use clap::Subcommand;

#[derive(Subcommand)]
pub(in crate::cli) enum Command {
    Train(train::Arguments),
    Superres(superres::Arguments),
    Fit(fit::Arguments),
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
            Command::Superres(arguments) => superres::run(arguments, output),
            Command::Fit(arguments) => fit::run(arguments, output),
            Command::Plot(arguments) => plot::run(arguments, output),
        }
    }
}
