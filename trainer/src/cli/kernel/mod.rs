//! The commands of scattered data: `sinew kernel ...`.

mod check;
mod command;
mod describe;
mod eval;
mod plot;
mod train;

pub(super) use command::Command;
pub(super) use describe::describe;
