//! Linear blend skinning (LBS) and the input of every fit: poses, trajectories and prior weights.
//!
//! The skin as a part of a file is in `model` and `bake`.

pub mod blend;
pub mod poses;
pub mod prior;
pub mod projection;
pub mod targets;
pub mod training;
pub mod weights;
