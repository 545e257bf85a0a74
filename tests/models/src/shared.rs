//! The sets of `../shared/data`, for tests.

use std::path::{Path, PathBuf};

/// Returns the path of a file or folder; `None` without shared data.
///
/// # Panics
/// If the file is missing where `CI` is set.
pub fn shared(file: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(file);
    if path.exists() {
        return Some(path);
    }
    assert!(std::env::var_os("CI").is_none(), "{file} must be in ../shared/data");
    eprintln!("{file} is not in ../shared/data: not tested");
    None
}
