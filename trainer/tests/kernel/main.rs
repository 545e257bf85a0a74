//! Tests of functions of scattered data: against other solvers, brute force and closed forms.
#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

mod baked;
mod common;
mod edge_cases;
mod left_out;
mod published;
mod reproduction;
mod rotations;
mod rounding;
mod scipy;
#[path = "../shared/mod.rs"]
mod shared;
