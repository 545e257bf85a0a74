//! The command line: one file a subcommand.

mod bars;
mod check;
mod demo;
mod eval;
mod export;
mod export_demo;
mod files;
mod input;
mod inspect;
mod levels;
mod measured;
mod report;
mod space;
mod table;
mod train;

use anyhow::Context;
use clap::{Parser, Subcommand};
use std::fmt::Display;
use std::io::{ErrorKind, Write};
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

/// What goes to the terminal.
#[derive(clap::Args, Clone, Copy)]
struct Output {
    /// No progress, no warnings: results and errors alone
    #[arg(long, short, global = true, display_order = 100)]
    quiet: bool,
    /// Results as one JSON object on standard output
    #[arg(long, global = true, display_order = 100)]
    json: bool,
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

impl Output {
    /// Tells on standard error what should be known about a file, unless quiet.
    fn warn(self, about: impl Display, warning: impl Display) {
        if !self.quiet {
            tell(&format!("warning: {about}: {warning}"));
        }
    }

    /// Prints a result: as JSON where that is asked for, else as text.
    fn print(self, json: &impl serde::Serialize, text: &str) -> anyhow::Result<()> {
        let text = if self.json { &serde_json::to_string_pretty(json)? } else { text };
        let mut out = std::io::stdout().lock();
        match writeln!(out, "{}", text.trim_end()).and_then(|()| out.flush()) {
            // Whoever closed the pipe has read enough.
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
            done => done.context("cannot write to standard output"),
        }
    }
}

/// Writes a line to standard error; where that is closed there is no one left to tell.
fn tell(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "sinew: {}", printable(line));
}

/// Joins an error and its causes; an error that already ends with its cause's words is not echoed.
fn in_a_line(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |text, cause| {
        let cause = cause.to_string();
        match text.as_str() {
            "" => cause,
            _ if text.ends_with(&cause) => text,
            _ => format!("{text}: {cause}"),
        }
    })
}

/// Escapes control characters: names come from files, and files must not steer a terminal.
fn printable(text: &str) -> String {
    text.chars().fold(String::with_capacity(text.len()), |mut out, character| {
        if character.is_control() {
            out.extend(character.escape_default());
        } else {
            out.push(character);
        }
        out
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_well_formed() {
        Cli::command().debug_assert();
    }

    #[test]
    fn causes_are_told_once() {
        let cause = anyhow::anyhow!("inner").context("outer: inner").context("file");
        assert_eq!(in_a_line(&cause), "file: outer: inner");
    }

    #[test]
    fn names_cannot_steer_a_terminal() {
        assert_eq!(printable("a\u{1b}[2J\r\nb°"), "a\\u{1b}[2J\\r\\nb°");
    }
}
