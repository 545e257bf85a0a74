//! Progress bars: the step, how far it is, and the time left.

use super::Output;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use sinew_trainer::envelope::rotational::STEPS;
use sinew_trainer::progress::Progress;

/// One bar, for the step at hand.
pub(super) struct Bars(ProgressBar);

impl Bars {
    /// Shows bars on standard error, unless quiet or where it is no terminal.
    pub(super) fn new(output: Output) -> Self {
        let target =
            if output.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(0), target);
        let template = "{prefix:>6} {msg:<20} {bar:30} {percent:>3} %  {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        Self(bar)
    }
}

impl Progress for Bars {
    fn step(&self, name: &'static str, items: usize) {
        let number = STEPS.iter().position(|&step| step == name).map_or(0, |index| index + 1);
        self.0.set_prefix(format!("{number}/{}", STEPS.len()));
        self.0.set_message(name);
        self.0.set_position(0);
        self.0.set_length(items as u64);
        self.0.reset_eta();
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
