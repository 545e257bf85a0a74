//! What several fits compute with, and that knows nothing of a character.

pub mod affine;
pub mod basis;
pub mod cluster;
pub(crate) mod columns;
pub(crate) mod dot;
pub mod frame;
pub mod points;
pub(crate) mod registers;
pub(crate) mod ridge;
pub mod simplex;
pub mod so3;
