//! The envelope's commands, one a file.

mod check;
mod command;
mod demo;
mod eval;
mod export;
mod export_demo;
mod inspect;
mod levels;
mod measured;
mod report;
mod train;

pub(super) use command::Command;
