//! What a long fit tells whoever waits for it.

/// Hears of the steps of a fit. Calls may come from several threads.
pub trait Progress: Sync {
    /// The fit of one of so many candidates begins.
    fn part(&self, number: usize, of: usize);
    /// A step of so many items begins; the last one is over.
    fn step(&self, name: &'static str, items: usize);
    /// So many more items are done.
    fn advance(&self, items: usize);
}

/// Hears nothing.
pub struct Silent;

impl Progress for Silent {
    fn part(&self, _: usize, _: usize) {}
    fn step(&self, _: &'static str, _: usize) {}
    fn advance(&self, _: usize) {}
}
