//! The file: its layout, defined here once for reader and writer.
//!
//! `FORMAT.md` is the byte-level contract. A file is one postcard message, [`File`], with a table of
//! parts and one of sections; what the sections of a part hold is the part's affair.

pub(crate) mod content;
mod crc;
mod error;
pub(crate) mod loading;
mod manifest;
mod message;
pub(crate) mod part;
pub(crate) mod rule;
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
pub use space::{Axis, Handedness, Space};
pub use tables::{Element, PartKind, PartRow, SectionKind, SectionRow};
