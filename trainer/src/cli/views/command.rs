//! The commands of views, by name.

use super::{animate, demo, drive, eval, export, pin, render, report, train, transfer};
use crate::cli::Output;
use clap::Subcommand;

#[derive(Subcommand)]
pub(in crate::cli) enum Command {
    Demo(demo::Arguments),
    Train(train::Arguments),
    Eval(eval::Arguments),
    Render(render::Arguments),
    Animate(animate::Arguments),
    Drive(drive::Arguments),
    Transfer(transfer::Arguments),
    Pin(pin::Arguments),
    Report(report::Arguments),
    Export(export::Arguments),
}

impl Command {
    /// Does what it says.
    ///
    /// # Errors
    /// Bad input, or a file that cannot be written.
    pub(in crate::cli) fn run(&self, output: Output) -> anyhow::Result<()> {
        match self {
            Command::Demo(arguments) => demo::run(arguments, output),
            Command::Train(arguments) => train::run(arguments, output),
            Command::Eval(arguments) => eval::run(arguments, output),
            Command::Render(arguments) => render::run(arguments, output),
            Command::Animate(arguments) => animate::run(arguments, output),
            Command::Drive(arguments) => drive::run(arguments, output),
            Command::Transfer(arguments) => transfer::run(arguments, output),
            Command::Pin(arguments) => pin::run(arguments, output),
            Command::Report(arguments) => report::run(arguments, output),
            Command::Export(arguments) => export::run(arguments, output),
        }
    }
}
