//! Modules one way: no file of a crate imports, by way of however many others, from one that imports
//! from it.
//!
//! An import is a path, in a `use` or anywhere else, and leads to the file that *defines* what it
//! names: re-exports are followed. So a `mod.rs` re-exports or defines. One that does both, and whose
//! children use what it defines, closes a circle. `mod child;` is no import, and what stands under
//! `#[cfg(test)]` does not count.

mod check;
mod circles;
mod parse;
mod resolve;
#[cfg(test)]
mod tests;
mod tokens;

pub(crate) use check::check;
