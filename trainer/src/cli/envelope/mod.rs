//! The envelope's commands, one a file.

mod check;
mod command;
mod demo;
mod describe;
mod eval;
mod export;
mod export_demo;
mod levels;
mod measured;
mod report;
mod table;
mod train;
mod warnings;

pub(super) use command::Command;
pub(super) use describe::describe;
