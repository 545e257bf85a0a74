//! The golden files.

use std::path::{Path, PathBuf};

/// Names of the golden files, one a predictor: rotational, kernel, hybrid.
pub const GOLDEN_NAMES: [&str; 3] =
    ["envelope-3-rotational.snw", "envelope-3-kernel.snw", "envelope-3-hybrid.snw"];

/// The golden files, as [`GOLDEN_NAMES`].
pub const GOLDEN: [&[u8]; 3] = [
    include_bytes!("../../golden/envelope-3-rotational.snw"),
    include_bytes!("../../golden/envelope-3-kernel.snw"),
    include_bytes!("../../golden/envelope-3-hybrid.snw"),
];

/// Returns where a golden file lies; of an empty name, their folder.
pub fn golden_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../golden").join(name)
}
