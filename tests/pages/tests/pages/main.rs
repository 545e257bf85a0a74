//! The pages for an engine's developer.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod axes;
mod crowd;
mod large_world;
mod links;
mod math;
mod mesh;
mod method;
mod shown;
mod skeleton;
mod web;
mod workspace;
