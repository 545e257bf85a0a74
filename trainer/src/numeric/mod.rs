//! Numerical methods that several fits share; they know nothing of characters.

pub mod affine;
pub mod basis;
pub(crate) mod columns;
pub(crate) mod grid;
pub mod simplex;
pub mod so3;
pub mod trs;
