//! The examples, compiled and run: by this machine's compilers, and on a Cortex-M4F.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;
mod cortex;
mod host;
mod linked;
mod parts;
