//! The command line: one file a subcommand.

mod bars;
mod check;
mod command;
mod demo;
mod eval;
mod export;
mod export_demo;
mod files;
mod input;
mod inspect;
mod levels;
mod measured;
mod output;
mod report;
mod space;
mod table;
mod train;

pub(crate) use command::main;
use output::{Output, printable};
