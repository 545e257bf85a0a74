//! The page of a report and its sections.

mod document;
mod errors;
mod frames;
mod pictures;
mod sizes;

pub use document::Page;
