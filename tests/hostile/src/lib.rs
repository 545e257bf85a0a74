//! Hostile files, how they are made and what is done to them.
//!
//! [`targets`] holds the body of every fuzz target of `tests/fuzz`; the tests of this crate and
//! `mutants` run the same bodies on stable Rust.

pub mod abi;
pub mod evaluate;
mod files;
mod filters;
mod kernels;
pub mod mutants;
pub mod poses;
mod priors;
pub mod recipe;
pub mod round_trip;
pub mod targets;
mod views;

pub use files::files;
