//! Pins with a prior: against dense solves, for every way to hold weights, and by the identities of
//! S0 §3.

mod bad_calls;
mod common;
mod learned;
mod pins;
mod posed;
mod theory;
mod trackers;
