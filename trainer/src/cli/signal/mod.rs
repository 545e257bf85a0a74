//! The commands of signals and images: `sinew signal ...`.

mod command;
mod describe;
mod fit;
mod options;
mod plot;
mod superres;
mod train;

pub(super) use command::Command;
pub(super) use describe::describe;
