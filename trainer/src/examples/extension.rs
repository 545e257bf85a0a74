//! Formats by the endings of their files.

use super::error::ExamplesError;
use super::rig::ImportError;
use std::path::Path;

/// The end of a file's name, in lower case, without the dot.
pub(super) fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// Says which formats are read instead of this file's.
pub(super) fn unknown_format(path: &Path, expected: &'static str) -> ExamplesError {
    let found = match extension(path) {
        none if none.is_empty() => "none".to_owned(),
        found => format!(".{found}"),
    };
    ImportError::UnknownFormat { expected, found }.into()
}
