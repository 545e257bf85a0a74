//! Other solvers' functions by their own names and rules (METHOD §2.4, §2.7): they warn where a fit of ours
//! would be refused, as their originals return.

pub mod canonical;
mod neighbours;
pub mod published;
pub mod scipy;
