//! The file format: its layout, defined once for reader and writer.
//!
//! `FORMAT.md` is the byte-level contract. A file is one postcard message, with a table
//! of parts and a table of sections. Each kind of part defines the content of its sections.
//!
//! Loading checks in this order, which FORMAT.md states:
//!
//! 1. the message and its checksum (`manifest`);
//! 2. the tables of parts and sections (`manifest`);
//! 3. every part of a known kind: its counts, then its sections (`part`, by the part's table
//!    `RULES`), then their content (the part's own checks).
//!
//! `Contents::read` in `model.rs` runs the steps.
//!
//! A new kind of part needs: a kind in `tables` and its sections in `sections`; a module beside
//! `envelope` with its counts, its table of rules, its checks and its views; an arm in each `match`
//! of `model.rs`; a chapter in FORMAT.md and a test of the chapter in `tests/format/document`. The
//! C ABI and the GPU show a part only if they evaluate it.

pub(crate) mod content;
pub(crate) mod crc;
mod error;
pub(crate) mod flat;
mod manifest;
mod message;
pub(crate) mod part;
pub(crate) mod refusal;
pub(crate) mod rule;
mod sections;
mod space;
mod tables;

pub(crate) use error::saturated;
pub use error::{FileError, FileErrorKind};
pub use manifest::FileId;
pub(crate) use manifest::Manifest;
pub use message::VERSION;
#[cfg_attr(feature = "internals", visibility::make(pub))]
pub(crate) use message::{
    ALIGNMENT, CHECKSUM_OFFSET, CORRECTION_MAX, FEATURES, File, MAGIC, MAGNITUDE_MAX, TRAVEL_MAX,
    checksum,
};
pub use sections::SectionKind;
pub use space::{Axis, Handedness, Space};
pub(crate) use tables::EVALUATED;
pub use tables::PartKind;
#[cfg_attr(feature = "internals", visibility::make(pub))]
pub(crate) use tables::{Element, PartRow, SectionRow};
