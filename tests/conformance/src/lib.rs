//! What the conformance tests share: backends, the models and poses they are run on, tolerances and
//! comparators.
#![forbid(unsafe_code)]

pub mod backend;
pub mod compare;
pub mod models;
pub mod poses;
pub mod tolerance;
