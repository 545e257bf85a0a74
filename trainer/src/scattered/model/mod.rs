//! A function with names: what a fit makes of a problem, what is baked, and what a file is compared with.

mod from_file;
mod function;
mod input;
mod output;

pub use from_file::inputs_of;
pub use function::{Evaluated, Figures, KernelModel};
pub(crate) use input::features;
pub use input::{EvaluationError, Input, InputKind, query_numbers};
pub use output::{Output, OutputKind};
