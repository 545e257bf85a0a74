//! The commands of views: `sinew views ...`.

mod animate;
mod command;
mod demo;
mod describe;
mod drive;
mod eval;
mod export;
mod frames;
mod input;
mod path;
mod pin;
mod pixels;
mod render;
mod report;
mod track;
mod train;
mod transfer;
mod values;

pub(super) use command::Command;
pub(super) use describe::describe;
