//! Progress reports of a long fit.

/// Receives the steps of a fit. Calls may come from several threads.
pub trait Progress: Sync {
    /// The fit of candidate `number` out of `of` begins.
    fn part(&self, number: usize, of: usize);
    /// A step of `items` items begins; the step before is complete.
    fn step(&self, name: &'static str, items: usize);
    /// `items` more items are complete.
    fn advance(&self, items: usize);
}

/// Ignores all reports.
pub struct Silent;

impl Progress for Silent {
    fn part(&self, _: usize, _: usize) {}
    fn step(&self, _: &'static str, _: usize) {}
    fn advance(&self, _: usize) {}
}
