//! The matrix: every stage on every device of this machine, in figures.

mod markdown;
mod page;
mod table;

pub use markdown::markdown;
pub use page::page;
pub use table::{Column, Matrix, Row, Scope};
