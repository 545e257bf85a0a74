//! The stages on every device that is here, by both APIs: each alone on the CPU's inputs, and from
//! end to end. What evaluates a batch on a device is first held against a device that is a program.

mod filter;
mod gpu;
mod kernel;
mod lavapipe;
mod matrix;
mod shapes;
mod software;
