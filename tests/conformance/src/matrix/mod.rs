//! The matrix: figures of every stage on every device of this machine.

mod page;
mod table;

pub use page::{markdown, page};
pub use table::{Column, Matrix, Row, Scope};
