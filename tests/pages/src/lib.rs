//! Runs the content of the pages for engine developers: their code, figures and builds.
//!
//! `build.rs` extracts the Rust code of a page, so that a test calls exactly the lines that a
//! reader copies. The character is the demo's arm, whose skeleton, mesh and poses are realistic.

pub mod arm;
pub mod browser;
pub mod build;

use std::path::{Path, PathBuf};

/// Returns the repository's folder.
pub fn repository() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.ancestors().nth(2).expect("this package lies two folders below the root").to_owned()
}

/// Reads a file of the repository.
///
/// # Panics
/// If the file is missing.
pub fn read(path: &str) -> String {
    let found = std::fs::read_to_string(repository().join(path));
    found.unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Returns the blocks of a page in one language, in order.
pub fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    let fence = format!("```{language}\n");
    let blocks = page.split(fence.as_str()).skip(1);
    blocks.filter_map(|rest| rest.split_once("```")).map(|(block, _)| block).collect()
}
