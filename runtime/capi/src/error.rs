//! What went wrong, in numbers: no text is formatted, so that none need fit into small flash.

use crate::{sinew_status, sinew_subject};
use sinew_runtime::{EvalError, FormatError, format};

/// What went wrong; written only when a call returns another status than `SINEW_STATUS_OK`.
///
/// Each status says which fields it fills; the others are 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_error {
    /// What the call returned.
    pub status: sinew_status,
    /// What it is about.
    pub subject: sinew_subject,
    /// A joint, vertex, row, group or place.
    pub index: u64,
    /// What should have been there: an exact value, the least or the most, as the status says.
    pub expected: u64,
    /// What was there.
    pub found: u64,
}

impl sinew_error {
    pub(crate) const fn new(status: sinew_status, subject: sinew_subject) -> Self {
        Self { status, subject, index: 0, expected: 0, found: 0 }
    }

    const fn of(status: sinew_status) -> Self {
        Self::new(status, sinew_subject::None)
    }

    pub(crate) const fn at(self, index: usize) -> Self {
        Self { index: index as u64, ..self }
    }

    pub(crate) const fn expected(self, expected: u64) -> Self {
        Self { expected, ..self }
    }

    pub(crate) const fn found(self, found: u64) -> Self {
        Self { found, ..self }
    }
}

impl From<EvalError> for sinew_error {
    fn from(error: EvalError) -> Self {
        use sinew_status as Status;
        match error {
            EvalError::Length { argument, expected, found } => {
                Self::new(Status::Length, argument.into())
                    .expected(expected as u64)
                    .found(found as u64)
            }
            EvalError::TooShort { argument, least, found } => {
                Self::new(Status::TooShort, argument.into())
                    .expected(least as u64)
                    .found(found as u64)
            }
            EvalError::NonFinite { joint } => {
                Self::new(Status::NonFinite, sinew_subject::Pose).at(joint)
            }
            EvalError::ZeroRotation { joint } => {
                Self::new(Status::ZeroRotation, sinew_subject::Local).at(joint)
            }
            EvalError::VertexRange { start, end, vertex_len } => {
                Self::new(Status::OutOfRange, sinew_subject::Vertices)
                    .at(start)
                    .expected(vertex_len as u64)
                    .found(end as u64)
            }
            EvalError::Stride { least, found } => {
                Self::of(Status::Stride).expected(least as u64).found(found as u64)
            }
            EvalError::NoTangents => Self::new(Status::NoTangents, sinew_subject::Tangents),
            EvalError::Predictor { found } => {
                Self::of(Status::NoStage).found(u64::from(found.number()))
            }
        }
    }
}

impl From<FormatError> for sinew_error {
    fn from(error: FormatError) -> Self {
        use sinew_status as Status;
        let row = |status, row| Self::of(status).at(row);
        match error {
            FormatError::Limit { quantity, most, found } => {
                Self::new(Status::Limit, quantity.into())
                    .expected(u64::from(most))
                    .found(u64::from(found))
            }
            FormatError::Malformed => Self::of(Status::Malformed),
            FormatError::Magic { found } => {
                let word = |bytes| u64::from(u32::from_le_bytes(bytes));
                Self::of(Status::Magic).expected(word(format::MAGIC)).found(word(found))
            }
            FormatError::Version { expected, found } => {
                Self::of(Status::Version).expected(u64::from(expected)).found(u64::from(found))
            }
            FormatError::Checksum { expected, found } => {
                Self::of(Status::Checksum).expected(u64::from(expected)).found(u64::from(found))
            }
            FormatError::TrailingBytes { found } => {
                Self::of(Status::TrailingBytes).found(found as u64)
            }
            FormatError::Features { unknown } => {
                Self::of(Status::Features).found(u64::from(unknown))
            }
            FormatError::Alignment { log2 } => Self::of(Status::Alignment).found(u64::from(log2)),
            FormatError::Padding => Self::of(Status::Padding),
            FormatError::PartTable { bytes } => Self::of(Status::PartTable).found(bytes as u64),
            FormatError::SectionTable { bytes } => {
                Self::of(Status::SectionTable).found(bytes as u64)
            }
            FormatError::Flags { found } => Self::of(Status::Flags).found(u64::from(found)),
            FormatError::UnknownPart { kind } => {
                Self::of(Status::UnknownPart).found(u64::from(kind))
            }
            FormatError::UnknownSection { kind } => {
                Self::of(Status::UnknownSection).found(u64::from(kind))
            }
            FormatError::SectionPart { row: at, found } => {
                row(Status::SectionPart, at).found(u64::from(found))
            }
            FormatError::SectionAlignment { row: at } => row(Status::SectionAlignment, at),
            FormatError::SectionOverlap { row: at } => row(Status::SectionOverlap, at),
            FormatError::SectionBounds { row: at } => row(Status::SectionBounds, at),
            FormatError::DuplicateSection { row: at } => row(Status::DuplicateSection, at),
            FormatError::Predictor { found } => Self::of(Status::Predictor).found(u64::from(found)),
            FormatError::Empty { quantity } => {
                Self::new(Status::Empty, quantity.into()).expected(1)
            }
            FormatError::MissingSection { section } => {
                Self::new(Status::MissingSection, section.into())
            }
            FormatError::UnexpectedSection { section } => {
                Self::new(Status::UnexpectedSection, section.into())
            }
            FormatError::SectionLength { section, expected, found } => {
                Self::new(Status::SectionLength, section.into())
                    .expected(u64::from(expected))
                    .found(found as u64)
            }
            FormatError::Name { index } => row(Status::Name, index),
            FormatError::Hierarchy { joint } => row(Status::Hierarchy, joint),
            FormatError::Float { section, index } => {
                let subject = section.map_or(sinew_subject::Certificate, sinew_subject::from);
                Self::new(Status::Float, subject).at(index)
            }
            FormatError::Index { section, index, below, found } => {
                Self::new(Status::Index, section.into())
                    .at(index)
                    .expected(below as u64)
                    .found(found as u64)
            }
            FormatError::Weights { vertex } => row(Status::Weights, vertex),
            FormatError::InverseBind { joint } => row(Status::InverseBind, joint),
            FormatError::Twist { key } => row(Status::Twist, key),
            FormatError::Kernel { group, found } => {
                row(Status::Kernel, group).found(u64::from(found))
            }
            FormatError::Reserved { group } => row(Status::Reserved, group),
            FormatError::EmptyGroup { group } => row(Status::EmptyGroup, group),
            FormatError::Fade { group } => row(Status::Fade, group),
            FormatError::GroupOffset { group, expected, found } => row(Status::GroupOffset, group)
                .expected(u64::from(expected))
                .found(u64::from(found)),
            FormatError::GroupProxies { expected, found } => {
                Self::of(Status::GroupProxies).expected(u64::from(expected)).found(u64::from(found))
            }
            FormatError::Scratch { expected, found } => {
                Self::of(Status::Scratch).expected(u64::from(expected)).found(u64::from(found))
            }
            FormatError::RestBox { index, vertex } => {
                row(Status::RestBox, index).found(vertex as u64)
            }
        }
    }
}
