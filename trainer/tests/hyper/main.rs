//! Tests of learned centres and metrics: their errors, their limits, and their independence of
//! irrelevant inputs.
#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

mod franke;
mod limits;
mod metric;
mod problem;
mod refusals;
mod starts;
mod traces;
