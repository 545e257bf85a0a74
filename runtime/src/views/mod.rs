//! The part views: a drawn object between its key views (METHOD §6).
//!
//! [`FrameJob::run`] goes from parameters to points, by a map that is a kernel of the same file; [`RenderJob::run`] from
//! points to a picture: `order` says which element is drawn first, `raster` maps textures to the pixels that `cover`
//! finds.

pub(crate) mod check;
mod counts;
mod cover;
mod frame;
mod order;
mod raster;
mod render;
mod texture;
mod view;

pub(crate) use counts::RULES;
pub use counts::{NO_POINT, VIEWS_SECTIONS, ViewsCounts, ViewsFit};
pub use frame::{Found, Frame, FrameJob};
pub use render::{Drawn, Order, RenderJob};
pub use texture::Texture;
pub use view::{Element, Views, ViewsLayout};
