//! Learns how a character's skin moves from examples, and bakes what it learned into a model for
//! [`sinew_runtime`].
#![forbid(unsafe_code)]

pub mod examples;
