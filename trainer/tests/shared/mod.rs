//! The sets of `../shared/data`, for the tests that read them.

use std::path::{Path, PathBuf};

/// Gives the place of a file or folder; none where there is no shared data, which continuous
/// integration must have.
pub(crate) fn shared(file: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data").join(file);
    if path.exists() {
        return Some(path);
    }
    assert!(std::env::var_os("CI").is_none(), "{file} must be in ../shared/data");
    eprintln!("{file} is not in ../shared/data: not tested");
    None
}
