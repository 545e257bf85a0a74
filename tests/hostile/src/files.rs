//! The files that everything starts from.

use crate::golden::GOLDEN;
use crate::pieces;
use std::sync::LazyLock;

/// Lists the files that everything starts from: the golden ones, and one of several parts.
///
/// # Panics
/// If a golden file is not sound.
pub fn files() -> &'static [Vec<u8>] {
    static FILES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
        let several = pieces::several().expect("the golden files are sound");
        GOLDEN.map(<[u8]>::to_vec).into_iter().chain([several]).collect()
    });
    &FILES
}
