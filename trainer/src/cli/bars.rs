//! Progress: the step, how far it is, and the time left.

use super::Output;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use sinew_trainer::progress::Progress;
use std::fmt::Write;
use std::time::Duration;

/// A step whose items are counted.
const COUNTED: &str = "{prefix}{msg:<22} {bar:30} {percent:>3} %  {left}";
/// A step of which only the beginning and the end are known.
const BUSY: &str = "{prefix}{msg:<22} {spinner} {elapsed}";
/// How often the line is drawn again, so that it is seen to live between two items.
const TICK: Duration = Duration::from_millis(200);

/// One bar, for the step at hand; it vanishes when dropped.
pub(super) struct Bars(ProgressBar);

impl Bars {
    /// Shows bars on standard error, unless quiet or where it is no terminal.
    pub(super) fn new(output: Output) -> Self {
        let target =
            if output.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        Self(ProgressBar::with_draw_target(None, target))
    }

    /// Shows that one thing is being done.
    pub(super) fn busy(output: Output, what: &'static str) -> Self {
        let bars = Self::new(output);
        bars.begin(what, 1);
        bars
    }

    fn begin(&self, message: &'static str, items: usize) {
        self.0.disable_steady_tick();
        if let Ok(style) = ProgressStyle::with_template(if items > 1 { COUNTED } else { BUSY }) {
            self.0.set_style(style.with_key("left", left));
        }
        self.0.set_message(message);
        self.0.set_length(items as u64);
        self.0.reset();
        self.0.enable_steady_tick(TICK);
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
        if of > 1 {
            self.0.set_prefix(format!("{number}/{of} "));
        }
    }

    fn step(&self, name: &'static str, items: usize) {
        self.begin(name, items);
    }

    fn advance(&self, items: usize) {
        self.0.inc(items as u64);
    }
}

impl Drop for Bars {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
