//! Result of an importer.

use crate::examples::{Clip, Examples, Warning};

/// Result of an importer.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// Valid examples.
    pub examples: Examples,
    /// Consecutive clips that cover all frames.
    pub clips: Vec<Clip>,
    /// Repaired or ignored content, and content that a fit will ignore.
    pub warnings: Vec<Warning>,
}
