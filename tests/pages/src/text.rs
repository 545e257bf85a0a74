//! The pages' text.

use std::path::{Path, PathBuf};

/// Returns the repository's folder.
pub fn repository() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.ancestors().nth(2).expect("this package stands two folders down").to_owned()
}

/// Reads a file of the repository.
///
/// # Panics
/// If it is not there.
pub fn read(path: &str) -> String {
    let found = std::fs::read_to_string(repository().join(path));
    found.unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Returns the blocks of a page in a language, in order.
pub fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    let fence = format!("```{language}\n");
    let blocks = page.split(fence.as_str()).skip(1);
    blocks.filter_map(|rest| rest.split_once("```")).map(|(block, _)| block).collect()
}
