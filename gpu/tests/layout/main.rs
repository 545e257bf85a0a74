//! Batches and their plans, without a device.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

#[path = "../common/mod.rs"]
mod common;
mod filter;
mod kernel;
mod plans;
mod refusals;
mod shapes;
