//! The stages on every device of the machine, through both APIs: each alone on the CPU's inputs,
//! and from pose to skin. The code that evaluates a batch on a device is tested first on a
//! simulated device.

mod filter;
mod gpu;
mod kernel;
mod lavapipe;
mod matrix;
mod shapes;
mod software;
