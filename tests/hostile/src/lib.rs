//! Makes hostile files and runs the runtime on them.
//!
//! [`targets`] holds the body of every fuzz target of `tests/fuzz`. The tests of this crate and
//! `mutants` run those bodies on stable Rust.

pub mod abi;
pub mod evaluate;
mod files;
mod parts;
pub mod poses;
pub mod recipe;
pub mod round_trip;
pub mod targets;
mod views;

pub use files::files;
