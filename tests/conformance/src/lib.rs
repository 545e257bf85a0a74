//! What the conformance tests and the programs share: backends, the models and poses they are run
//! on, tolerances, comparators, and one body a stage.
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
