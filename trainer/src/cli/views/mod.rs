//! The commands of views: `sinew views ...`.

mod describe;
mod eval;
mod export;
mod frames;
mod input;
mod render;
mod track;
mod train;

use super::Output;
use clap::Subcommand;

pub(super) use describe::describe;

#[derive(Subcommand)]
pub(in crate::cli) enum Command {
    Demo(train::Demo),
    Train(train::Train),
    Eval(eval::Eval),
    Render(render::Render),
    Animate(frames::Animate),
    Drive(frames::Drive),
    Transfer(train::Transfer),
    Pin(render::PinPoints),
    Report(eval::Report),
    Export(export::Export),
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// Bad input, or a file that cannot be written.
    pub(in crate::cli) fn run(&self, output: Output) -> anyhow::Result<()> {
        match self {
            Command::Demo(arguments) => train::write_demo(arguments, output),
            Command::Train(arguments) => train::train_set(arguments, output),
            Command::Eval(arguments) => eval::eval(arguments, output),
            Command::Render(arguments) => render::render(arguments, output),
            Command::Animate(arguments) => frames::animate(arguments, output),
            Command::Drive(arguments) => frames::drive(arguments, output),
            Command::Transfer(arguments) => train::transfer_motion(arguments, output),
            Command::Pin(arguments) => render::pin(arguments, output),
            Command::Report(arguments) => eval::write_report(arguments, output),
            Command::Export(arguments) => export::export(arguments, output),
        }
    }
}
