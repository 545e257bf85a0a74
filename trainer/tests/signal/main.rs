//! Tests of signals: against the reference's numbers, another library, closed forms and other
//! resamplers.
#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

mod baked;
mod common;
mod images;
mod others;
mod reference;
#[path = "../shared/mod.rs"]
mod shared;
mod theory;
