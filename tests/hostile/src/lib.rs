//! Hostile files, how they are made and what is done to them.
//!
//! [`targets`] holds the body of every fuzz target of `tests/fuzz`; the tests of this crate and
//! `mutants` run the same bodies on stable Rust.

pub mod abi;
pub mod evaluate;
pub mod mutants;
pub mod pieces;
pub mod poses;
pub mod recipe;
pub mod round_trip;
pub mod targets;

use std::sync::LazyLock;

/// The golden files, one a predictor.
pub const GOLDEN: [&[u8]; 3] = [
    include_bytes!("../../golden/envelope-3-rotational.snw"),
    include_bytes!("../../golden/envelope-3-kernel.snw"),
    include_bytes!("../../golden/envelope-3-hybrid.snw"),
];

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
