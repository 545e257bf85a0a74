//! The file: its layout, defined here once for reader and writer.
//!
//! `FORMAT.md` is the byte-level contract. A file is one postcard message, [`File`], with a table of
//! parts and one of sections; what the sections of a part hold is the part's affair.
//!
//! Loading checks in this order, which FORMAT.md states: the message and its checksum (`manifest`), the
//! tables of parts and sections (`manifest`), then every part of a kind that this reader knows: its counts
//! (`counts` in the `check.rs` of the part's folder), which sections it has (`part`, by the `RULES` in that
//! folder's `counts.rs`), and what they hold (`CHECKS` in its `check.rs`). What goes from one to the next
//! is `Found::read` in `model.rs`.
//!
//! A new kind of part adds: a kind in `tables` and its sections in `sections`; a folder beside `envelope` with its counts, its table of rules and its table of checks; an arm each where `model.rs` picks them;
//! its views; its page in FORMAT.md, and there `tests/format/document.rs`. The C ABI and the GPU show a
//! part only where they evaluate it.

pub(crate) mod content;
pub(crate) mod crc;
mod error;
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
pub use message::{
    ALIGNMENT, CHECKSUM_OFFSET, CORRECTION_MAX, FEATURES, File, MAGIC, MAGNITUDE_MAX, TRAVEL_MAX,
    VERSION, checksum,
};
pub use sections::SectionKind;
pub use space::{Axis, Handedness, Space};
pub use tables::{Element, PartKind, PartRow, SectionRow};
