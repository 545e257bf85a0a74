//! Tests of signals: against the reference's numbers, another library, closed forms and other
//! resamplers.

mod baked;
mod common;
mod images;
mod others;
mod reference;
mod theory;
