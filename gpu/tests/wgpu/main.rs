//! The stages on wgpu: against the CPU's bits, and against a host's mistakes.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod bits;
#[path = "../common/mod.rs"]
mod common;
mod kernels;
mod refusals;
