//! What learned centres and metrics reach, where they end in a limit, and what they must not depend on.
#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

mod franke;
mod limits;
mod methods;
mod metric;
mod problem;
mod reference;
mod refusals;
mod starts;
mod traces;
