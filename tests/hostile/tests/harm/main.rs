//! Whether any bytes or arguments do harm: files damaged, lying, once found by a fuzzer, or baked at random.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod goldens;
mod promises;
mod replay;
mod round_trip;
