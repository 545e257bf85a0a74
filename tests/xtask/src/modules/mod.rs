//! One-way modules: no two files of a crate import from each other, directly or through other
//! files.
//!
//! An import is a path, in a `use` or anywhere else. It leads to the file that *defines* the name:
//! re-exports are followed. So a `mod.rs` should either re-export or define. A `mod.rs` that does
//! both, and whose children use its definitions, closes a circle. `mod child;` is not an import,
//! and code under `#[cfg(test)]` does not count.

mod check;
mod parse;
mod resolve;
#[cfg(test)]
mod tests;
mod tokens;

pub(crate) use check::check;
