//! The part prior: how the weights of a skin's shapes belong together, and what pins do with that (METHOD §5.1).
//!
//! [`PinJob::run`] goes from pins to weights: `observation` makes rows of them, `active_set` finds the weights that
//! fit, between their bounds, with a factor that `packed` makes. All of it is f64 inside: a drag of a thousand steps
//! must not drift.

mod active_set;
pub(crate) mod check;
mod counts;
mod job;
mod observation;
mod packed;
mod pins;
mod scratch;
mod view;

pub(crate) use counts::RULES;
pub use counts::{PRIOR_SECTIONS, PriorCounts, PriorFit};
pub use job::{Anchor, Edit, PinJob, Temporal};
pub use pins::{Pin, PinList, Pins};
pub use view::{Prior, PriorLayout};
