//! Posed meshes from files of their own, beside a rig that has the joints.

mod data;
mod error;
mod mdd;
mod obj;
mod pc2;
mod points;
mod read;
#[cfg(test)]
mod tests;

pub(super) use data::Targets;
pub use error::TargetsError;
pub use pc2::save_pc2;
pub(super) use read::{files, read};
