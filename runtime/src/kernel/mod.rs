//! The part kernel: any function of a few numbers, fitted to scattered data (METHOD §2).
//!
//! [`KernelMap::evaluate`] computes outputs from a query. `features` turns the inputs, including
//! rotations, into numbers. `point` shifts and scales these numbers, and computes coordinates for
//! distances. `function` is the kernel itself. `evaluate` combines the kernels into values, and the
//! values into outputs. `jacobian` and `variance` start at the same point.

pub(crate) mod check;
mod counts;
mod evaluate;
mod features;
mod function;
mod jacobian;
mod point;
mod rows;
mod rule;
mod variance;
mod view;

pub use counts::KernelFit;
pub(crate) use counts::RULES;
#[cfg_attr(feature = "internals", visibility::make(pub))]
pub(crate) use counts::{KERNEL_SECTIONS, KernelCounts, NO_TERM};
pub use function::Kernel;
pub use rows::{EulerOrder, InputKind, InputRow, OutputKind, OutputRow};
pub use rule::{KernelRule, Normalise, QueryRule};
pub use view::KernelMap;
