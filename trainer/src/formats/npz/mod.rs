//! Arrays of NumPy: `.npz` archives of them, read and written, and `.npy` files of one.

mod error;
mod read;
mod write;

pub use error::ArrayError;
pub(crate) use read::{Archive, Number, Rows, read_npy};
pub(crate) use write::Writer;
