//! Shared by the conformance tests and programs: backends, models and poses, tolerances,
//! comparators, and one function for each stage that compares a backend with the oracle.
#![forbid(unsafe_code)]

pub mod backend;
pub mod compare;
pub mod cpu;
pub mod devices;
pub mod filters;
pub mod finding;
pub mod gpu;
pub mod kernels;
pub mod matrix;
pub mod models;
pub mod poses;
pub mod shapes;
pub mod stages;
pub mod subject;
pub mod tolerance;
pub mod vectors;
