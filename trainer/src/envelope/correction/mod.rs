//! What kernel maps add to a base, from the pose: fitted for helpers and for what a reconstruction
//! leaves over alike (METHOD §1.9).

pub mod candidates;
pub mod features;
pub mod group_outputs;
mod listening;
pub mod lists;
pub mod metric;
pub(super) mod rounding;
pub mod search;
pub mod target;
