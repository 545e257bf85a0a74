//! What every fit reads: the skin's trajectories, its poses, and how a skin is blended. The
//! skin as a part of a file is `model/skin.rs` and `bake/skin.rs`.

pub mod blend;
pub mod own;
pub mod poses;
pub mod prior;
pub mod projection;
pub mod residuals;
pub mod stacked;
pub mod targets;
pub mod training;
pub mod weights;
