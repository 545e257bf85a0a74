//! The command line: what all commands share, and a folder for the commands of each part.

mod bars;
mod column;
mod command;
mod described;
mod envelope;
mod face;
mod files;
mod input;
mod inspect;
mod kernel;
mod output;
mod signal;
mod space;
mod views;

pub(crate) use command::main;
use output::{Output, counted, printable};
