//! The envelope's commands, one a file.

pub(super) mod check;
pub(super) mod demo;
pub(super) mod eval;
pub(super) mod export;
pub(super) mod export_demo;
pub(super) mod inspect;
mod levels;
mod measured;
pub(super) mod report;
pub(super) mod train;
