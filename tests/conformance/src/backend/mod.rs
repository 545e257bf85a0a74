//! The stages as every backend offers them: a batch of poses in, outputs for all of them.

mod cpu;
mod interface;

pub use cpu::Cpu;
pub use interface::{
    Backend, Failure, Gradients, Loaded, Whole, attributes, floats, part, poisoned_attributes,
    poisoned_out, poisoned_transforms,
};
