//! Batches and their plans, without a device.

mod filter;
mod kernel;
mod plans;
mod refusals;
mod shapes;
