//! The part views: a drawn object between its key views (METHOD §6).
//!
//! [`FrameJob::run`] goes from parameters to points, by a map that is a kernel of the same file; [`RenderJob::run`] from
//! points to a picture, layer by layer: `blend` says which key views an element has its colours from, `order` which
//! element is drawn first, `raster` maps textures to the pixels that `cover` finds.

mod blend;
pub(crate) mod check;
mod counts;
#[cfg(feature = "raster")]
mod cover;
mod frame;
#[cfg(feature = "raster")]
mod raster;
#[cfg(feature = "raster")]
mod render;
#[cfg(feature = "raster")]
mod sample;
mod view;

pub use blend::Blend;
pub(crate) use counts::RULES;
pub use counts::{
    CLIP_ELEMENTS_MAX, CLIPS_MAX, FITS_MAX, NO_VERTEX, NOTHING, VIEWS_SECTIONS, ViewsCounts,
    ViewsFit,
};
pub use frame::{Found, Frame, FrameJob};
#[cfg(feature = "raster")]
pub use render::{Drawn, RenderJob, RenderScratch};
pub use view::{Element, Layer, Texture, Vertex, Views, ViewsLayout};
