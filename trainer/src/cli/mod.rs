//! The command line: shared arguments and results, and a folder of commands for each part.

/// Makes the enum of a folder's commands. Each variant holds the arguments of a command, which implement [`Run`].
macro_rules! commands {
    ($($(#[$about:meta])* $name:ident($arguments:ty),)*) => {
        #[derive(clap::Subcommand)]
        pub(in crate::cli) enum Command {
            $($(#[$about])* $name($arguments),)*
        }

        impl $crate::cli::Run for Command {
            fn run(&self, output: $crate::cli::Output) -> anyhow::Result<$crate::cli::Report> {
                match self {
                    $(Self::$name(arguments) => arguments.run(output),)*
                }
            }
        }
    };
}

mod arguments;
mod envelope;
mod face;
mod files;
mod input;
mod inspect;
mod kernel;
mod output;
mod report;
mod signal;
mod views;

use arguments::{ModelArgs, POSITIVE, StatedSpace, count, load, named, number, space_as_json};
use clap::{CommandFactory, FromArgMatches, Parser};
use files::{OfFile, OutputFile, ending};
use output::{Bars, Output, counted, in_a_line, printable, tell};
use report::{COLUMNS, Report, Run, table};
use std::process::ExitCode;

commands! {
    #[command(flatten)]
    Envelope(Box<envelope::Command>),
    Inspect(inspect::Inspect),
    /// Turns scattered data into functions
    ///
    /// Functions turn poses into shapes, or any numbers into others.
    #[command(subcommand, after_help = "Example:\n  sinew kernel train wrist.json -o wrist.sinew")]
    Kernel(kernel::Command),
    /// Drags a few points of a face and lets the rest follow
    ///
    /// The rest moves as in a recorded take.
    #[command(subcommand, after_help = "Example:\n  sinew face train --basis head.npz -o head.sinew")]
    Face(face::Command),
    /// Makes pictures between pictures, from a few views of an object
    ///
    /// The views have matched points; any other view follows from them.
    #[command(subcommand, after_help = "Example:\n  sinew views demo demo")]
    Views(views::Command),
    /// Makes signals and images finer, and functions of observations
    ///
    /// Observations are values, derivatives and averages.
    #[command(subcommand, after_help = "Example:\n  sinew signal superres in.png --factor 2 -o out.png")]
    Signal(signal::Command),
}

/// Learns how a character's skin moves from example poses, bakes it into a small file, and measures
/// that file against linear blend skinning (LBS).
#[derive(Parser)]
#[command(name = "sinew", version, arg_required_else_help = true, max_term_width = COLUMNS)]
#[command(after_help = "Example, which needs no input:\n  sinew demo\n\n\
    Exit status: 0 done, 1 failed (bad input, or a file that cannot be written), 2 bad usage.")]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    output: Output,
}

/// Where the words of every help are explained.
const WORDS: &str = "Helper, palette, envelope, confidence: runtime/README.md explains such words, under \"Words\".";

/// Adds a reference to [`WORDS`] to the long help of each command.
fn explained(command: clap::Command) -> clap::Command {
    let own = command.get_after_help().map(|own| format!("{own}\n\n")).unwrap_or_default();
    command.after_long_help(own + WORDS).mut_subcommands(explained)
}

/// Runs the program `sinew` with the arguments of this process.
pub fn main() -> ExitCode {
    let matches = explained(Cli::command()).get_matches();
    let Cli { command, output } =
        Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let done = output.start().and_then(|()| command.run(output)?.print(output));
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
    use unicode_width::UnicodeWidthStr;

    #[test]
    fn the_command_line_is_well_formed() {
        explained(Cli::command()).debug_assert();
    }

    /// Calls something with every command and its name as it is typed.
    fn each(mut command: clap::Command, of: &mut dyn FnMut(&str, &clap::Command)) {
        fn walk(before: &str, command: &clap::Command, of: &mut dyn FnMut(&str, &clap::Command)) {
            let name = format!("{before} {}", command.get_name());
            of(&name, command);
            command.get_subcommands().for_each(|command| walk(&name, command, of));
        }
        command.build();
        walk("", &command, of);
    }

    /// Columns of usual terminals.
    const TERMINALS: [usize; 2] = [80, COLUMNS];

    #[test]
    fn every_help_fits_the_terminal() {
        for columns in TERMINALS {
            each(explained(Cli::command().term_width(columns)), &mut |name, command| {
                let mut command = command.clone();
                for help in [command.render_help(), command.render_long_help()] {
                    for line in help.to_string().lines() {
                        // The library never breaks a line of usage.
                        let most = if line.starts_with("Usage:") { COLUMNS } else { columns };
                        assert!(line.width() <= most, "{name}, {columns} columns: {line}");
                    }
                }
            });
        }
    }

    #[test]
    fn every_summary_is_one_line() {
        each(explained(Cli::command().term_width(TERMINALS[0])), &mut |name, command| {
            let help = command.clone().render_help().to_string();
            for own in command.get_subcommands() {
                let summary = own.get_about().map(ToString::to_string).unwrap_or_default();
                let begins = format!("{} ", own.get_name());
                let line = help.lines().find(|line| line.trim_start().starts_with(&begins));
                let line = line.unwrap_or_default();
                assert!(!summary.is_empty() && line.ends_with(&summary), "{name}: {line}");
            }
        });
    }

    #[test]
    fn every_help_has_an_example_and_leads_to_the_words() {
        // Lines are broken at the width of the terminal.
        let plain = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        each(explained(Cli::command()), &mut |name, command| {
            // The library adds the command `help`.
            if !name.contains(" help") {
                let own = command.get_after_help().map(ToString::to_string).unwrap_or_default();
                let help = command.clone().render_long_help().to_string();
                let words = plain(&format!("{own} {WORDS}"));
                assert!(own.contains("Example") && plain(&help).ends_with(&words), "{help}");
            }
        });
    }
}
