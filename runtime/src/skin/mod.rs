//! Skins: from a palette to positions, normals and tangents (METHOD §1.8).

mod blend;
mod bounds;
pub(crate) mod check;
mod counts;
mod evaluate;
mod job;
mod normals;
mod output;
#[cfg_attr(target_os = "none", path = "no_scratch.rs")]
mod scratch;
#[cfg(feature = "shapes")]
mod shapes;
#[cfg(not(target_os = "none"))]
mod vectors;
mod view;

pub use bounds::Bounds;
pub(crate) use counts::RULES;
#[cfg_attr(feature = "internals", visibility::make(pub))]
pub(crate) use counts::{
    BLOCK, LENGTH_TOLERANCE, NO_ENVELOPE, SKIN_SECTIONS, SkinCounts, WEIGHT_SUM_TOLERANCE,
};
pub use counts::{NormalErrors, ShapeErrors};
pub use job::SkinJob;
pub use output::Output;
pub use scratch::CacheLine;
#[cfg(feature = "shapes")]
pub use shapes::ShapesJob;
pub use view::{Skin, mesh_hash_of};
