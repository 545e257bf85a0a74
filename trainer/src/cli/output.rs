//! What a command prints.

use anyhow::Context;
use std::fmt::Display;
use std::io::{ErrorKind, Write};

/// What goes to the terminal.
#[derive(clap::Args, Clone, Copy)]
pub(super) struct Output {
    /// No progress, no warnings: results and errors alone
    #[arg(long, short, global = true, display_order = 100)]
    pub(super) quiet: bool,
    /// Results as one JSON object on standard output
    #[arg(long, global = true, display_order = 100)]
    pub(super) json: bool,
    /// Threads to work on; results are the same for any number [default: one a core]
    #[arg(long, value_name = "N", global = true, display_order = 100)]
    #[arg(value_parser = clap::value_parser!(u16).range(1..))]
    pub(super) threads: Option<u16>,
}

impl Output {
    /// Sets how many threads work.
    ///
    /// # Errors
    /// If they cannot be made.
    pub(super) fn start(self) -> anyhow::Result<()> {
        let Some(threads) = self.threads else { return Ok(()) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global().context("cannot start the threads")
    }

    /// Tells on standard error what should be known about a file, unless quiet.
    pub(super) fn warn(self, about: impl Display, warning: impl Display) {
        if !self.quiet {
            tell(&format!("warning: {about}: {warning}"));
        }
    }

    /// Tells on standard error what is good to know about a file and asks for nothing, unless quiet.
    pub(super) fn note(self, about: impl Display, note: impl Display) {
        if !self.quiet {
            tell(&format!("note: {about}: {note}"));
        }
    }

    /// Prints a result: as JSON where that is asked for, else as text.
    pub(super) fn print(self, json: &impl serde::Serialize, text: &str) -> anyhow::Result<()> {
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
pub(super) fn tell(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "sinew: {}", printable(line));
}

/// Joins an error and its causes; an error that already ends with its cause's words is not echoed.
pub(super) fn in_a_line(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |text, cause| {
        let cause = cause.to_string();
        match text.as_str() {
            "" => cause,
            _ if text.ends_with(&cause) => text,
            _ => format!("{text}: {cause}"),
        }
    })
}

/// Says how many there are of something.
pub(super) fn counted(len: usize, one: &str, many: &str) -> String {
    if len == 1 { format!("1 {one}") } else { format!("{len} {many}") }
}

/// Escapes control characters: names come from files, and files must not steer a terminal.
pub(super) fn printable(text: &str) -> String {
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
