//! The sections of a report, from top to bottom.

mod document;
mod error;
mod frames;
mod histogram;
mod joints;
mod pictures;
mod series;
mod sizes;

pub use document::Page;
pub use error::ReportError;
