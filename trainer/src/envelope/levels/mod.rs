//! Further meshes on a model's palette, so that one prediction drives every level of detail.

mod add;
mod follow;
mod nearest;
mod place;

pub use add::{AddError, OWN, add, check_names, reserve};
pub use follow::{Influences, Level, LevelError, LevelReport, SkinSurface};
pub use place::{NEAR, check_places};
