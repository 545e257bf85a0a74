//! What an importer returns.

use crate::examples::{Clip, Examples, Warning};

/// What an importer returns: the examples, and what the user should know about them.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The examples, valid.
    pub examples: Examples,
    /// The clips that its frames come from, in order, which together cover them.
    pub clips: Vec<Clip>,
    /// What was repaired, ignored, or will be left out by a fit.
    pub warnings: Vec<Warning>,
}
