//! Skins: from a palette to positions, normals and tangents (METHOD §1.8).

mod blend;
mod bounds;
pub(crate) mod check;
mod counts;
mod evaluate;
mod job;
mod normals;
mod output;
#[cfg(feature = "shapes")]
mod shapes;
mod simd;
mod view;

pub use bounds::Bounds;
pub(crate) use counts::RULES;
pub use counts::{
    BLOCK, LENGTH_TOLERANCE, NO_ENVELOPE, NormalErrors, SKIN_SECTIONS, ShapeErrors, SkinCounts,
    WEIGHT_SUM_TOLERANCE,
};
pub use job::{Rest, SkinJob};
pub use output::{Output, cells};
#[cfg(feature = "shapes")]
pub use shapes::ShapesJob;
pub use view::{Skin, SkinLayout, mesh_hash_of};
