//! Batches and their plans, without a device.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

#[path = "../common/mod.rs"]
mod common;
mod filters;
mod kernels;
mod parts;
mod plans;
mod shapes;
