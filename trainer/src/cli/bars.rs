//! Progress: how far the whole is, the step at hand, and the time that it takes.

use super::Output;
use super::output::tell;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use sinew_trainer::progress::Progress;
use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Several parts, of which so many are done, and the step of the one at hand.
const PARTS: &str = "{prefix} {bar:30} {percent:>3} %  {msg:<22} {elapsed}";
/// A step whose items are counted.
const COUNTED: &str = "{msg:<22} {bar:30} {percent:>3} %  {left}";
/// A step of which only the beginning and the end are known.
const BUSY: &str = "{msg:<22} {spinner} {elapsed}";
/// How often the line is drawn again, so that it is seen to live between two items.
const TICK: Duration = Duration::from_millis(200);
/// How often a line is written where there is no terminal.
const LINE: Duration = Duration::from_secs(10);
/// What a part is long in the bar of all.
const PART: f64 = 1000.0;

/// One bar for the whole; it vanishes when dropped. Without a terminal, a line now and then.
pub(super) struct Bars {
    bar: ProgressBar,
    state: Mutex<State>,
    writes_lines: bool,
}

/// How far the whole is.
struct State {
    /// The part at hand, from 1, of so many.
    part: (usize, usize),
    /// Share of it that is done.
    done: f64,
    /// Items of the step at hand, and how many are done.
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

    /// Shows that one thing is being done.
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
            // How many steps a part has is not known: each takes half of what is left of it.
            let own = done + (1.0 - done) / 2.0 * reached as f64 / all.max(1) as f64;
            self.bar.set_position((PART * (number as f64 - 1.0 + own)) as u64);
        } else {
            self.bar.set_position(reached as u64);
        }
    }

    /// Writes a line where there is no terminal, if the last one is long ago.
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

/// Writes the time left, once one item has told how long an item takes.
fn left(state: &ProgressState, out: &mut dyn Write) {
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
