//! Output of a command: its result, warnings, errors and progress.

use crate::examples::{Severity, Warning};
use crate::progress::Progress;
use anyhow::Context;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::fmt::Display;
use std::io::{IsTerminal, Write};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Options of every command.
#[derive(clap::Args, Clone, Copy)]
#[command(next_help_heading = "Every command")]
pub(super) struct Output {
    /// Print no progress and no warnings
    #[arg(long, short, global = true, display_order = 100)]
    pub(super) quiet: bool,
    /// Print the result as one JSON object
    #[arg(long, global = true, display_order = 100)]
    pub(super) json: bool,
    /// Number of threads; results are the same for any number [default: one a core]
    #[arg(long, value_name = "N", global = true, display_order = 100)]
    #[arg(value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
}

impl Output {
    /// Sets the number of threads.
    ///
    /// # Errors
    /// The threads cannot be started.
    pub(super) fn start(self) -> anyhow::Result<()> {
        let Some(threads) = self.threads else { return Ok(()) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global().context("cannot start the threads")
    }

    /// Prints a warning about a file to standard error, unless quiet.
    pub(super) fn warn(self, about: impl Display, warning: impl Display) {
        if !self.quiet {
            tell(&format!("warning: {about}: {warning}"));
        }
    }

    /// Prints a note about a file, which asks for no action, to standard error, unless quiet.
    pub(super) fn note(self, about: impl Display, note: impl Display) {
        if !self.quiet {
            tell(&format!("note: {about}: {note}"));
        }
    }

    /// Prints a warning or note about one or several files.
    pub(super) fn report(self, about: impl Display, warning: &Warning) {
        match warning.severity() {
            Severity::Warning => self.warn(about, warning),
            Severity::Note => self.note(about, warning),
        }
    }
}

/// Writes a line to standard error. A closed standard error is ignored.
pub(super) fn tell(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "sinew: {}", printable(line));
}

/// Joins an error and its causes in one line. A cause that the error already ends with is not repeated.
pub(super) fn in_a_line(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |text, cause| {
        let cause = cause.to_string();
        match text.as_str() {
            "" => cause,
            _ if text.ends_with(&cause) => text,
            // The cause names the file itself.
            _ if cause.starts_with(&format!("{text}: ")) => cause,
            _ => format!("{text}: {cause}"),
        }
    })
}

/// Writes a count with its noun.
pub(super) fn counted(len: usize, one: &str, many: &str) -> String {
    if len == 1 { format!("1 {one}") } else { format!("{len} {many}") }
}

/// Escapes control characters: names come from files, and a file must not control the terminal.
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

/// Line for several parts: the share that is done, and the current step.
const PARTS: &str = "{prefix} {bar:30} {percent:>3} %  {msg:<22} {elapsed}";
/// Line for a step with a known number of items.
const COUNTED: &str = "{msg:<22} {bar:30} {percent:>3} %  {left}";
/// Line for a step of unknown length.
const BUSY: &str = "{msg:<22} {spinner} {elapsed}";
/// Time between two drawings of the line, short enough to show activity between two items.
const TICK: Duration = Duration::from_millis(200);
/// Time between two lines if standard error is no terminal.
const LINE: Duration = Duration::from_secs(10);
/// Length of a part in the bar of all parts.
const PART: f64 = 1000.0;

/// Progress bar of all parts, cleared when dropped. Without a terminal, it is a line every [`LINE`].
pub(super) struct Bars {
    bar: ProgressBar,
    state: Mutex<State>,
    writes_lines: bool,
}

/// Progress of all parts.
struct State {
    /// Number of the current part, from 1, and number of parts.
    part: (usize, usize),
    /// Share of the current part that is done.
    done: f64,
    /// Number of items of the current step, and number of items that are done.
    items: (usize, usize),
    last_line: Instant,
}

impl Bars {
    /// Shows a bar on standard error, unless quiet.
    pub(super) fn new(output: Output) -> Self {
        let target =
            if output.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        Self {
            bar: ProgressBar::with_draw_target(None, target),
            state: Mutex::new(State {
                part: (1, 1),
                done: 0.0,
                items: (1, 0),
                last_line: Instant::now(),
            }),
            writes_lines: !output.quiet && !std::io::stderr().is_terminal(),
        }
    }

    /// Shows a step of unknown length.
    pub(super) fn busy(output: Output, what: &'static str) -> Self {
        let bars = Self::new(output);
        bars.step(what, 1);
        bars
    }

    fn with(&self, change: impl FnOnce(&mut State)) {
        let mut state = self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        change(&mut state);
        let State { part: (number, of), done, items: (all, reached), .. } = *state;
        if of > 1 {
            // The number of steps of a part is unknown: each step takes half of the remaining part.
            let own = done + (1.0 - done) / 2.0 * reached as f64 / all.max(1) as f64;
            self.bar.set_position((PART * (number as f64 - 1.0 + own)) as u64);
        } else {
            self.bar.set_position(reached as u64);
        }
    }

    /// Writes a line if there is no terminal and the last line is older than [`LINE`].
    fn line(&self, step: &str) {
        self.with(|state| {
            if self.writes_lines && state.last_line.elapsed() >= LINE {
                let (number, of) = state.part;
                let part = if of > 1 { format!("fit {number} of {of}, ") } else { String::new() };
                tell(&format!("working: {part}{step}"));
                state.last_line = Instant::now();
            }
        });
    }
}

/// Writes the remaining time, known after the first item.
fn left(state: &ProgressState, out: &mut dyn std::fmt::Write) {
    if (1..state.len().unwrap_or(0)).contains(&state.pos()) {
        let _ = write!(out, "{:#} left", indicatif::HumanDuration(state.eta()));
    }
}

impl Progress for Bars {
    fn part(&self, number: usize, of: usize) {
        self.bar.set_prefix(format!("{number}/{of}"));
        self.with(|state| {
            (state.part, state.done, state.items) = ((number, of), 0.0, (1, 0));
        });
    }

    fn step(&self, name: &'static str, items: usize) {
        let mut several = false;
        self.with(|state| {
            several = state.part.1 > 1;
            state.done += (1.0 - state.done) / 2.0 * f64::from(u8::from(state.items.1 > 0));
            state.items = (items, 0);
            self.bar.set_length(if several {
                (PART as usize * state.part.1) as u64
            } else {
                items as u64
            });
        });
        self.bar.disable_steady_tick();
        let template = match (several, items > 1) {
            (true, _) => PARTS,
            (false, true) => COUNTED,
            (false, false) => BUSY,
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            self.bar.set_style(style.with_key("left", left));
        }
        if !several {
            self.bar.reset();
        }
        self.bar.set_message(name);
        self.bar.enable_steady_tick(TICK);
        self.line(name);
    }

    fn advance(&self, items: usize) {
        self.with(|state| state.items.1 += items);
        self.line(&self.bar.message());
    }
}

impl Drop for Bars {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn causes_are_printed_once() {
        let cause = anyhow::anyhow!("inner").context("outer: inner").context("file");
        assert_eq!(in_a_line(&cause), "file: outer: inner");
    }

    #[test]
    fn names_cannot_control_a_terminal() {
        assert_eq!(printable("a\u{1b}[2J\r\nb°"), "a\\u{1b}[2J\\r\\nb°");
    }
}
