//! The part views: a drawn object between its key views (METHOD §6).
//!
//! [`FrameJob::run`] computes points from parameters, by a map: a kernel of the same file.
//! `RenderJob::run` draws a picture from points, layer by layer, with the feature `raster`. `blend`
//! chooses the key views of an element's colours, `render` draws the elements in order, `raster`
//! maps textures to the pixels from `cover`, and `sample` reads the textures.

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
pub use counts::ViewsFit;
#[cfg_attr(feature = "internals", visibility::make(pub))]
pub(crate) use counts::{
    CLIP_ELEMENTS_MAX, CLIPS_MAX, FITS_MAX, NO_VERTEX, NOTHING, VIEWS_SECTIONS, ViewsCounts,
};
pub use frame::{Found, Frame, FrameJob};
#[cfg(feature = "raster")]
pub use render::{Drawn, RenderJob, RenderScratch};
pub use view::{Element, Layer, Texture, Vertex, Views};
