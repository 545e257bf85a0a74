//! Tests of the pages for engine developers.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod api;
mod axes;
mod character;
mod crowd;
mod curves;
mod links;
mod math;
mod shown;
mod web;
mod workspace;
