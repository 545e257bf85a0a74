//! The commands of faces.

mod command;
mod describe;
mod eval;
mod input;
mod pin;
mod pins;
mod report;
mod solve;
mod train;

pub(super) use command::Command;
pub(super) use describe::describe;
