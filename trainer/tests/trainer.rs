//! Tests of the trainer.
#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

mod check;
mod cli;
mod face;
mod fit;
mod hyper;
mod kernel;
mod prior;
mod report;
mod signal;
mod views;
