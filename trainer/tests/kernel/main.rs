//! What functions of scattered data reach: against other solvers' numbers, brute force and closed forms.
#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

mod baked;
mod common;
mod edge_cases;
mod falloffs;
mod gradients;
mod left_out;
mod published;
mod reproduction;
mod rotations;
mod rounding;
mod scipy_bars;
mod scipy_cases;
#[path = "../shared/mod.rs"]
mod shared;
