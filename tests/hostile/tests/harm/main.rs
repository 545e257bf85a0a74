//! Checks that no bytes and no arguments do harm: damaged files, false files, findings of fuzzers,
//! and random bakes.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod calls;
mod goldens;
mod promises;
mod replay;
