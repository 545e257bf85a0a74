//! A file's first filter, as far as its calls go by it.

use sinew_runtime::Filter;

/// The most of each that a call takes: signals, samples beyond the window, lanes.
pub(super) const MOST: [usize; 3] = [2, 2, 9];

/// A file's first filter.
pub(super) struct Filtered {
    pub(super) name: String,
    pub(super) factor: usize,
    pub(super) tap_len: usize,
}

impl Filtered {
    pub(super) fn new(filter: &Filter<'_>) -> Self {
        let (name, factor) = (filter.name().to_owned(), filter.factor());
        Self { name, factor, tap_len: filter.tap_len() }
    }

    /// Returns the bytes of the most samples that a call takes.
    pub(super) fn sample_bytes(&self) -> usize {
        let [signals, more, lanes] = MOST;
        4 * signals * (self.tap_len + more) * lanes
    }

    /// Returns the bytes of what its calls write.
    pub(super) fn result_bytes(&self) -> usize {
        self.factor * self.sample_bytes()
    }
}
