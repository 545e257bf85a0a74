//! Pins with a prior: against dense solves, for every way to hold weights, and by the identities of
//! S0 §3.
#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

mod bad_calls;
mod common;
mod learned;
mod pins;
mod posed;
#[path = "../shared/mod.rs"]
mod shared;
mod theory;
mod trackers;
