//! The part prior: how the weights of a skin's shapes belong together, and what pins do with that (METHOD §5.1).
//!
//! [`PinJob::run`] goes from pins to weights: `observation` makes rows of them, `active_set` finds the weights that
//! fit, between their bounds, with a factor that `packed` makes. All of it is f64 inside: a drag of a thousand steps
//! must not drift.

mod active_set;
mod job;
mod packed;
mod part;
mod pins;
mod scratch;

pub use job::{Anchor, Edit, PinJob, Temporal};
pub use part::{PRIOR_SECTIONS, Prior, PriorCounts, PriorFit, PriorLayout};
pub(crate) use part::{RULES, check_content, check_counts};
pub use pins::{Pin, PinList, Pins};
