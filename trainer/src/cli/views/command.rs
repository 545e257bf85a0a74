//! The commands of views, by name.

use super::demo;
use crate::cli::Output;
use clap::Subcommand;

#[derive(Subcommand)]
pub(in crate::cli) enum Command {
    Demo(demo::Arguments),
}

impl Command {
    /// Does what it says.
    ///
    /// # Errors
    /// Bad input, or a file that cannot be written.
    pub(in crate::cli) fn run(&self, output: Output) -> anyhow::Result<()> {
        match self {
            Command::Demo(arguments) => demo::run(arguments, output),
        }
    }
}
