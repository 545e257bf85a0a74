//! The part record: what an envelope was trained on, so that whoever measures it later knows which frames it has seen
//! and what linear blend skinning makes of the same examples. Evaluation needs none of it.

pub(crate) mod check;
mod counts;
mod view;

pub(crate) use counts::RULES;
pub use counts::{MARK_LEN, RECORD_SECTIONS, RecordCounts};
pub use view::{Record, RecordLayout};
