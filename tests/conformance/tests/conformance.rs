//! Every backend against the f64 oracle.
#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

mod devices;
mod exact;
mod golden;
mod stages;
mod vectors;
