//! Results of evaluations, and refused calls.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod closed_forms;
#[path = "../common/mod.rs"]
mod common;
mod correction;
mod filter;
mod golden;
mod kernel;
mod normals;
mod outputs;
mod pictures;
mod poses;
mod reference;
mod refusals;
mod rest_mesh;
mod scratch;
mod shapes;
mod views;
