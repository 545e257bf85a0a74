//! A part of a file, as `sinew inspect` shows it.

use serde_json::Value;
use sinew_runtime::format::PartKind;

/// What is said of a part.
pub(in crate::cli) struct Described {
    /// Its place in the file.
    pub(in crate::cli) part: usize,
    /// What it is.
    pub(in crate::cli) kind: PartKind,
    /// Its name.
    pub(in crate::cli) name: String,
    /// For a reader.
    pub(in crate::cli) text: String,
    /// For a program.
    pub(in crate::cli) json: Value,
}
