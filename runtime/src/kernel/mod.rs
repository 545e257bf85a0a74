//! The part kernel: any function of a few numbers, from scattered data (METHOD §2).
//!
//! [`KernelMap::evaluate`] goes from a query to outputs: `features` makes numbers of what was given, rotations
//! among them; `point` shifts, scales and measures them; `value` is the kernel itself; `outputs` makes
//! of the values what is given back. `jacobian` and `variance` start from the same point.

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

pub(crate) use counts::RULES;
pub use counts::{KERNEL_SECTIONS, KernelCounts, KernelFit, NO_TERM};
pub use function::Kernel;
pub use rows::{EulerOrder, InputKind, InputRow, OutputKind, OutputRow};
pub use rule::{KernelRule, Normalise, QueryRule};
pub use view::{KernelLayout, KernelMap};
