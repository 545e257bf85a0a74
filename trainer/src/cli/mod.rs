//! The command line: what all commands share, and a folder for the commands of each part.

mod bars;
mod command;
mod envelope;
mod files;
mod input;
mod kernel;
mod output;
mod space;
mod table;

pub(crate) use command::main;
use output::{Output, printable};
