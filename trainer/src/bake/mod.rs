//! The only writer of the file that [`sinew_runtime`] reads.

mod envelope;
mod error;
mod groups;
mod model;
mod sections;
mod skin;

pub use envelope::{EnvelopeParts, Key, Reconstruction};
pub use error::BakeError;
pub use groups::Group;
pub use model::{ModelParts, bake};
pub use skin::SkinParts;
