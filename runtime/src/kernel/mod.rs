//! The part kernel: any function of a few numbers, from scattered data (METHOD §2).

mod function;

pub use function::Kernel;
