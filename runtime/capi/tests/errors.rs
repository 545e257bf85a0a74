//! Each error of the runtime becomes a status, and its numbers keep their places.

use sinew_capi::{sinew_error, sinew_status as Status, sinew_subject as Subject};
use sinew_runtime::format::{MAGIC, Predictor, SectionKind};
use sinew_runtime::{Argument, EvalError, FormatError, Quantity};

/// Builds the error that is expected: status, subject, index, expected, found.
fn error(status: Status, subject: Subject, numbers: [u64; 3]) -> sinew_error {
    let [index, expected, found] = numbers;
    sinew_error { status, subject, index, expected, found }
}

#[test]
fn of_calls() {
    let argument = Argument::Palette;
    let cases = [
        (
            EvalError::Length { argument, expected: 4, found: 5 },
            error(Status::Length, Subject::Palette, [0, 4, 5]),
        ),
        (
            EvalError::TooShort { argument: Argument::OutB, least: 4, found: 3 },
            error(Status::TooShort, Subject::OutB, [0, 4, 3]),
        ),
        (EvalError::NonFinite { joint: 6 }, error(Status::NonFinite, Subject::Pose, [6, 0, 0])),
        (
            EvalError::ZeroRotation { joint: 6 },
            error(Status::ZeroRotation, Subject::Local, [6, 0, 0]),
        ),
        (
            EvalError::VertexRange { start: 1, end: 9, vertex_len: 8 },
            error(Status::OutOfRange, Subject::Vertices, [1, 8, 9]),
        ),
        (EvalError::Stride { least: 3, found: 2 }, error(Status::Stride, Subject::None, [0, 3, 2])),
        (EvalError::NoTangents, error(Status::NoTangents, Subject::Tangents, [0; 3])),
        (
            EvalError::Predictor { found: Predictor::Hybrid },
            error(Status::NoStage, Subject::None, [0, 0, 3]),
        ),
    ];
    for (from, expected) in cases {
        assert_eq!(sinew_error::from(from), expected, "{from}");
    }
}

#[test]
fn of_files() {
    let none = Subject::None;
    let section = SectionKind::C1;
    let c1 = Subject::SectionC1;
    let magic = u64::from(u32::from_le_bytes(MAGIC));
    let cases = [
        (
            FormatError::Limit { quantity: Quantity::Joints, most: 7, found: 8 },
            error(Status::Limit, Subject::Joints, [0, 7, 8]),
        ),
        (FormatError::Malformed, error(Status::Malformed, none, [0; 3])),
        (FormatError::Magic { found: [1, 2, 0, 0] }, error(Status::Magic, none, [0, magic, 513])),
        (FormatError::Version { expected: 2, found: 9 }, error(Status::Version, none, [0, 2, 9])),
        (FormatError::Checksum { expected: 7, found: 8 }, error(Status::Checksum, none, [0, 7, 8])),
        (FormatError::TrailingBytes { found: 8 }, error(Status::TrailingBytes, none, [0, 0, 8])),
        (FormatError::Features { unknown: 8 }, error(Status::Features, none, [0, 0, 8])),
        (FormatError::Alignment { log2: 8 }, error(Status::Alignment, none, [0, 0, 8])),
        (FormatError::Padding, error(Status::Padding, none, [0; 3])),
        (FormatError::PartTable { bytes: 8 }, error(Status::PartTable, none, [0, 0, 8])),
        (FormatError::SectionTable { bytes: 8 }, error(Status::SectionTable, none, [0, 0, 8])),
        (FormatError::Flags { found: 8 }, error(Status::Flags, none, [0, 0, 8])),
        (FormatError::UnknownPart { kind: 8 }, error(Status::UnknownPart, none, [0, 0, 8])),
        (FormatError::UnknownSection { kind: 8 }, error(Status::UnknownSection, none, [0, 0, 8])),
        (
            FormatError::SectionPart { row: 6, found: 8 },
            error(Status::SectionPart, none, [6, 0, 8]),
        ),
        (
            FormatError::SectionAlignment { row: 6 },
            error(Status::SectionAlignment, none, [6, 0, 0]),
        ),
        (FormatError::SectionOverlap { row: 6 }, error(Status::SectionOverlap, none, [6, 0, 0])),
        (FormatError::SectionBounds { row: 6 }, error(Status::SectionBounds, none, [6, 0, 0])),
        (
            FormatError::DuplicateSection { row: 6 },
            error(Status::DuplicateSection, none, [6, 0, 0]),
        ),
        (FormatError::Predictor { found: 8 }, error(Status::Predictor, none, [0, 0, 8])),
        (
            FormatError::Empty { quantity: Quantity::Groups },
            error(Status::Empty, Subject::Groups, [0, 1, 0]),
        ),
        (FormatError::MissingSection { section }, error(Status::MissingSection, c1, [0; 3])),
        (FormatError::UnexpectedSection { section }, error(Status::UnexpectedSection, c1, [0; 3])),
        (
            FormatError::SectionLength { section, expected: 7, found: 8 },
            error(Status::SectionLength, c1, [0, 7, 8]),
        ),
        (FormatError::Name { index: 6 }, error(Status::Name, none, [6, 0, 0])),
        (FormatError::Hierarchy { joint: 6 }, error(Status::Hierarchy, none, [6, 0, 0])),
        (
            FormatError::Float { section: None, index: 6 },
            error(Status::Float, Subject::Certificate, [6, 0, 0]),
        ),
        (
            FormatError::Float { section: Some(section), index: 6 },
            error(Status::Float, c1, [6, 0, 0]),
        ),
        (
            FormatError::Index { section, index: 6, below: 7, found: 8 },
            error(Status::Index, c1, [6, 7, 8]),
        ),
        (FormatError::Weights { vertex: 6 }, error(Status::Weights, none, [6, 0, 0])),
        (FormatError::InverseBind { joint: 6 }, error(Status::InverseBind, none, [6, 0, 0])),
        (FormatError::Twist { key: 6 }, error(Status::Twist, none, [6, 0, 0])),
        (FormatError::Kernel { group: 6, found: 8 }, error(Status::Kernel, none, [6, 0, 8])),
        (FormatError::Reserved { group: 6 }, error(Status::Reserved, none, [6, 0, 0])),
        (FormatError::EmptyGroup { group: 6 }, error(Status::EmptyGroup, none, [6, 0, 0])),
        (FormatError::Fade { group: 6 }, error(Status::Fade, none, [6, 0, 0])),
        (
            FormatError::GroupOffset { group: 6, expected: 7, found: 8 },
            error(Status::GroupOffset, none, [6, 7, 8]),
        ),
        (
            FormatError::GroupProxies { expected: 7, found: 8 },
            error(Status::GroupProxies, none, [0, 7, 8]),
        ),
        (FormatError::Scratch { expected: 7, found: 8 }, error(Status::Scratch, none, [0, 7, 8])),
        (FormatError::RestBox { index: 6, vertex: 8 }, error(Status::RestBox, none, [6, 0, 8])),
    ];
    for (from, expected) in cases {
        assert_eq!(sinew_error::from(from), expected, "{from}");
    }
}
