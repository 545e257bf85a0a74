//! What every fit reads of the skin and its poses, and how a skin is blended.

pub mod blend;
pub mod folds;
pub mod poses;
pub mod projection;
pub mod stacked;
pub mod targets;
pub mod training;
pub mod weights;
