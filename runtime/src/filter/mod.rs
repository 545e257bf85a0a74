//! The part filter: makes a signal finer, or an image, by weights that depend on nothing but where a fine sample lies
//! between the coarse ones (METHOD §4).
//!
//! [`Filter::apply`] slides a window along the samples; the weights were baked, border by border and phase by phase.

mod apply;
pub(crate) mod check;
mod counts;
mod view;

pub use apply::Samples;
pub(crate) use counts::RULES;
pub use counts::{FILTER_SECTIONS, FilterCounts, FilterFit};
pub use view::{Filter, FilterLayout};
