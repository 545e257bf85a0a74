//! Skins: from a palette to positions, normals and tangents (METHOD §1.8).

mod blend;
mod bounds;
pub(crate) mod check;
mod coefficients;
mod counts;
mod eight;
mod job;
mod posed_bounds;
mod view;

pub use bounds::Bounds;
pub(crate) use counts::RULES;
pub use counts::{
    LENGTH_TOLERANCE, NO_ENVELOPE, NormalErrors, SKIN_SECTIONS, SkinCounts, WEIGHT_SUM_TOLERANCE,
};
pub use job::{Output, Rest, SkinJob, cells};
pub use view::{Skin, SkinLayout};
