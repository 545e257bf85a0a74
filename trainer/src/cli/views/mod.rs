//! The commands of views: `sinew views ...`.

mod command;
mod demo;

pub(super) use command::Command;
