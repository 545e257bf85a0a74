//! Valid and invalid files of records.

use crate::common::{exercise, file_error};
use models::{Pieces, RecordContent};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::SectionKind;
use sinew_runtime::record::RECORD_SECTIONS;
use sinew_runtime::{Envelope, FileError, FileErrorKind as Kind, Model, Record};

/// Loads a record after `edit` has changed its bytes.
fn edited(edit: impl FnOnce(&mut Pieces)) -> Result<(), FileError> {
    let mut pieces = Pieces::record(&RecordContent::sample());
    edit(&mut pieces);
    Model::from_bytes(pieces.bytes()).map(|_| ())
}

fn error(kind: Kind, section: SectionKind, index: u32) -> FileError {
    FileError { part: Some(0), section: Some(section), index, ..file_error(kind) }
}

#[test]
fn accessors_give_what_was_written() {
    let mut pieces = Pieces::small(Predictor::Kernel);
    pieces.add_record(&RecordContent { lbs: None, ..RecordContent::sample() });
    pieces.add_record(&RecordContent { name: "other".to_owned(), ..RecordContent::sample() });
    let bytes = pieces.bytes();
    exercise(&bytes).unwrap();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let own = model.first::<Envelope>().and_then(|envelope| model.named::<Record>(envelope.name()));
    let other = model.all::<Record>().find(|record| record.name() == "other").unwrap();
    let content = RecordContent::sample();
    let marks: Vec<f32> = other.frame_marks().flatten().collect();
    assert_eq!(marks, content.marks);
    let influences: Vec<_> = other.lbs_influences(1).unwrap().collect();
    assert_eq!(influences, [(1, 40_000.0 / 65_535.0), (0, 25_535.0 / 65_535.0)]);
    assert!(other.lbs_influences(2).is_none() && other.lbs_influences(usize::MAX).is_none());
    if let Some(own) = own {
        assert!(own.lbs_influences(0).is_none());
    }
}

#[test]
fn each_count_and_each_section_is_checked() {
    let section = SectionKind::RecordCounts;
    let count = |at: usize, value: u32| edited(|pieces| pieces.set_word(section, at, value));
    let length =
        |section, expected, found| FileError { expected, found, ..error(Kind::Length, section, 0) };
    assert_eq!(count(0, 4), Err(length(SectionKind::FrameMarks, 64, 48)));
    assert_eq!(count(1, 3), Err(length(SectionKind::LbsJoints, 12, 8)));
    assert_eq!(count(2, 0), Err(error(Kind::Unexpected, SectionKind::LbsJoints, 0)));
    let none = FileError { expected: 1, ..error(Kind::Empty, section, 3) };
    assert_eq!(count(3, 0), Err(none));
    let beyond =
        FileError { expected: 2, found: 2, ..error(Kind::Index, SectionKind::LbsJoints, 1) };
    assert_eq!(count(3, 2), Err(beyond));
    for section in RECORD_SECTIONS {
        let missing = edited(|pieces| pieces.sections.retain(|own| own.kind != section.number()));
        assert_eq!(missing, Err(error(Kind::Missing, section, 0)));
    }
    for value in [f32::NAN, f32::INFINITY, -1.0, 2.0e9] {
        let refused = edited(|pieces| pieces.set_float(SectionKind::FrameMarks, 2, value));
        assert_eq!(refused, Err(error(Kind::Float, SectionKind::FrameMarks, 2)), "{value}");
    }
}
