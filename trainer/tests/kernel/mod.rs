//! Tests of functions of scattered data: against other solvers, brute force and closed forms.

mod baked;
mod common;
mod edge_cases;
mod left_out;
mod published;
mod reproduction;
mod rotations;
mod rounding;
mod scipy;
