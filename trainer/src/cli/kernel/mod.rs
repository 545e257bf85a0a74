//! The commands of scattered data: `sinew kernel ...`.

mod check;
mod command;
mod eval;
mod plot;
mod train;

pub(super) use command::Command;
