//! The matrix: every stage on every device of this machine, in figures.

mod page;
mod table;

pub use page::{markdown, page};
pub use table::{Column, Matrix, Row, Scope};
