//! Accuracy of views between views: against held-out views, closed forms, and truth made by tests.

mod baked;
mod common;
mod deformation;
mod demo;
mod driven;
mod export;
mod faults;
mod flat;
mod instances;
mod layered;
mod left_out;
mod painted;
mod pictures;
mod pixels;
mod proposed;
mod puppets;
mod spine;
mod tiger;
mod turning;
