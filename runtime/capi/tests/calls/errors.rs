//! The errors of the runtime become those of C field by field, and their kinds one to one.

use sinew_capi::{SINEW_NO_PART, sinew_argument, sinew_argument_text, sinew_error, sinew_status};
use sinew_runtime::format::SectionKind;
use sinew_runtime::{Argument, CallError, CallErrorKind, FileError, FileErrorKind};
use std::ffi::CStr;
use std::fmt::Debug;

/// Every kind; `header/statuses.rs` counts the header's statuses against them.
const CALL_KINDS: [CallErrorKind; 12] = {
    use CallErrorKind::*;
    [
        Length,
        TooShort,
        NonFinite,
        ZeroRotation,
        OutOfRange,
        Stride,
        NoAttribute,
        NoStage,
        NoOutput,
        NoRoot,
        OtherName,
        NoJoints,
    ]
};
const FILE_KINDS: [FileErrorKind; 21] = {
    use FileErrorKind::*;
    [
        NotAModel,
        Version,
        Malformed,
        Checksum,
        Limit,
        Unsupported,
        PartIndex,
        Alignment,
        Overlap,
        Bounds,
        Duplicate,
        Missing,
        Unexpected,
        Length,
        Empty,
        Float,
        Index,
        Mismatch,
        Invalid,
        Truncated,
        Space,
    ]
};
const ARGUMENTS: [Argument; 22] = {
    use Argument::*;
    [
        Call,
        Pose,
        Local,
        Scratch,
        Palette,
        Confidences,
        Relative,
        Rotations,
        Gradients,
        Features,
        Vertices,
        Remap,
        RestPositions,
        RestNormals,
        RestTangents,
        Positions,
        Normals,
        Tangents,
        Query,
        Outputs,
        Jacobian,
        Variances,
    ]
};

fn name(value: impl Debug) -> String {
    format!("{value:?}")
}

#[test]
fn kinds_and_arguments_keep_their_names_and_order() {
    for (kind, number) in CALL_KINDS.into_iter().zip(1..) {
        let status = sinew_status::from(kind);
        assert_eq!((name(status), status as i32), (name(kind), number));
    }
    for (kind, number) in FILE_KINDS.into_iter().zip(100..) {
        let status = sinew_status::from(kind);
        assert_eq!((name(status), status as i32), (format!("File{kind:?}"), number));
    }
    for (argument, number) in ARGUMENTS.into_iter().zip(0..) {
        let same = sinew_argument::from(argument);
        assert_eq!((name(same), same as u32), (name(argument), number));
        // SAFETY: the library's texts end in a zero and are valid for ever.
        let text = unsafe { CStr::from_ptr(sinew_argument_text(same as u32)) };
        assert_eq!(text.to_str(), Ok(argument.name()));
    }
}

#[test]
fn errors_keep_every_field() {
    let (argument, kind) = (Argument::Remap, CallErrorKind::OutOfRange);
    let (index, expected, found) = (6, usize::MAX, 8);
    assert_eq!(
        sinew_error::from(CallError { kind, argument, index, expected, found }),
        sinew_error {
            status: sinew_status::OutOfRange,
            argument: sinew_argument::Remap,
            part: SINEW_NO_PART,
            section: 0,
            index,
            expected,
            found,
        }
    );
    let (kind, section) = (FileErrorKind::Index, Some(SectionKind::C1));
    let error = FileError { kind, part: Some(3), section, index: 6, expected: 7, found: u32::MAX };
    let in_c = sinew_error {
        status: sinew_status::FileIndex,
        argument: sinew_argument::File,
        part: 3,
        section: 10,
        index: 6,
        expected: 7,
        found: u32::MAX as usize,
    };
    assert_eq!(sinew_error::from(error), in_c);
    assert_eq!(
        sinew_error::from(FileError { part: None, section: None, ..error }),
        sinew_error { part: SINEW_NO_PART, section: 0, ..in_c }
    );
}
