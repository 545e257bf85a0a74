//! How long the steps of a fit take.

use crate::progress::Progress;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Takes the time of each step, and tells whoever else waits.
pub(super) struct Stopwatch<'a> {
    others: &'a dyn Progress,
    begun: Mutex<Vec<(&'static str, Instant)>>,
}

impl<'a> Stopwatch<'a> {
    /// Begins.
    pub(super) fn new(others: &'a dyn Progress) -> Self {
        Self { others, begun: Mutex::default() }
    }

    /// Ends, and gives the seconds of each step in the order in which they first began. What goes
    /// before the first step is not counted.
    pub(super) fn finish(self) -> Vec<(&'static str, f64)> {
        let mut begun = self.begun.into_inner().unwrap_or_else(PoisonError::into_inner);
        begun.push(("", Instant::now()));
        let mut steps: Vec<(&'static str, f64)> = Vec::new();
        for pair in begun.windows(2) {
            let (name, seconds) = (pair[0].0, (pair[1].1 - pair[0].1).as_secs_f64());
            match steps.iter_mut().find(|step| step.0 == name) {
                Some(step) => step.1 += seconds,
                None => steps.push((name, seconds)),
            }
        }
        steps
    }
}

impl Progress for Stopwatch<'_> {
    fn part(&self, _: usize, _: usize) {}

    fn step(&self, name: &'static str, items: usize) {
        let mut begun = self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        begun.push((name, Instant::now()));
        self.others.step(name, items);
    }

    fn advance(&self, items: usize) {
        self.others.advance(items);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use std::thread::sleep;
    use std::time::Duration;

    #[test]
    fn a_step_that_comes_again_is_counted_once_more() {
        let stopwatch = Stopwatch::new(&Silent);
        for (name, milliseconds) in [("a", 30), ("b", 10), ("a", 30)] {
            stopwatch.step(name, 1);
            sleep(Duration::from_millis(milliseconds));
        }
        let steps = stopwatch.finish();
        assert_eq!(steps.iter().map(|step| step.0).collect::<Vec<_>>(), ["a", "b"]);
        assert!(steps[0].1 >= 0.06 && steps[1].1 >= 0.01, "{steps:?}");
    }
}
