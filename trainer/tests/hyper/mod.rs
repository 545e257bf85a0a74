//! Tests of learned centres and metrics: their errors, their limits, and their independence of
//! irrelevant inputs.

mod franke;
mod limits;
mod metric;
mod problem;
mod refusals;
mod starts;
mod traces;
