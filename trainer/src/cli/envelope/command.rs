//! The envelope's commands, by name.

use super::{check, demo, eval, export, export_demo, report, train};
use crate::cli::Output;
use clap::Subcommand;

#[derive(Subcommand)]
pub(in crate::cli) enum Command {
    Demo(demo::Arguments),
    Check(check::Arguments),
    Train(train::Arguments),
    Eval(eval::Arguments),
    Report(report::Arguments),
    Export(export::Arguments),
    ExportDemo(export_demo::Arguments),
}

impl Command {
    /// Does what it says.
    ///
    /// # Errors
    /// Bad input, or a file that cannot be written.
    pub(in crate::cli) fn run(&self, output: Output) -> anyhow::Result<()> {
        match self {
            Command::Demo(arguments) => demo::run(arguments, output),
            Command::Check(arguments) => check::run(arguments, output),
            Command::Train(arguments) => train::run(arguments, output),
            Command::Eval(arguments) => eval::run(arguments, output),
            Command::Report(arguments) => report::run(arguments, output),
            Command::Export(arguments) => export::run(arguments, output),
            Command::ExportDemo(arguments) => export_demo::run(arguments, output),
        }
    }
}
