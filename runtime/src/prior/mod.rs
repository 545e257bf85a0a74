//! The part prior: a prior over the weights of a skin's shapes, and pins that use the prior (METHOD
//! §5.1).
//!
//! [`PinJob::run`] computes weights from pins. `pins` turns the pins into rows, and `active_set`
//! solves for the weights between their bounds, with the factorisation in `packed`. All arithmetic
//! is f64: a drag of a thousand steps must not drift.

mod active_set;
mod job;
mod packed;
mod part;
mod pins;
mod scratch;

pub use job::{Anchor, Edit, PinJob, Temporal};
#[cfg_attr(feature = "internals", visibility::make(pub))]
pub(crate) use part::{PRIOR_SECTIONS, PriorCounts};
pub use part::{Prior, PriorFit};
pub(crate) use part::{RULES, check_content, check_counts};
pub use pins::{Pin, PinList, Pins};
