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

/// The golden files, one a predictor.
pub const GOLDEN: [&[u8]; 3] = [
    include_bytes!("../../golden/envelope-2-rotational.snw"),
    include_bytes!("../../golden/envelope-2-kernel.snw"),
    include_bytes!("../../golden/envelope-2-hybrid.snw"),
];
