//! Valid and invalid files of filters.

use crate::common::{exercise, file_error};
use models::{FilterContent, Pieces};
use sinew_runtime::filter::FILTER_SECTIONS;
use sinew_runtime::format::{PartRow, SectionKind};
use sinew_runtime::{FileError, FileErrorKind as Kind, Filter, Model};

/// Loads a filter after `edit` has changed its bytes.
fn edited(edit: impl FnOnce(&mut Pieces)) -> Result<(), FileError> {
    let mut pieces = Pieces::filter(&FilterContent::sample(2, 5));
    edit(&mut pieces);
    Model::from_bytes(pieces.bytes()).map(|_| ())
}

fn error(kind: Kind, section: SectionKind, index: u32) -> FileError {
    FileError { part: Some(0), section: Some(section), index, ..file_error(kind) }
}

#[test]
fn sound_files_load_beside_other_parts() {
    for (factor, tap_len) in [(1, 1), (2, 5), (3, 9), (7, 3)] {
        exercise(&Pieces::filter(&FilterContent::sample(factor, tap_len)).bytes()).unwrap();
    }
    let mut several = Pieces::several();
    let other = FilterContent { name: "other".to_owned(), ..FilterContent::sample(3, 3) };
    several.add_filter(&FilterContent::sample(2, 5));
    several.add_filter(&FilterContent { variances: None, ..other });
    several.sections.reverse();
    let bytes = several.bytes();
    exercise(&bytes).unwrap();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let found: Vec<_> =
        model.all::<Filter>().map(|filter| (filter.name(), filter.factor())).collect();
    assert_eq!(found, [("filter", 2), ("other", 3)]);
    assert_eq!(model.named::<Filter>("other").unwrap().variance(0, 0), None);
}

#[test]
fn accessors_give_what_was_written() {
    let content = FilterContent::sample(2, 5);
    let bytes = Pieces::filter(&content).bytes();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let filter = model.first::<Filter>().unwrap().layout().open::<Filter>(&bytes).unwrap();
    assert_eq!((filter.factor(), filter.tap_len(), filter.name()), (2, 5, "filter"));
    let variances = content.variances.unwrap();
    for place in 0..5 {
        for phase in 0..2 {
            let row = 2 * place + phase;
            assert_eq!(filter.variance(place, phase), Some(variances[row]));
            for tap in 0..5 {
                assert_eq!(filter.tap(place, phase, tap), Some(content.taps[5 * row + tap]));
            }
        }
    }
    for (place, phase, tap) in [(5, 0, 0), (0, 2, 0), (0, 0, 5), (usize::MAX, usize::MAX, 0)] {
        assert_eq!(filter.tap(place, phase, tap), None);
    }
    assert_eq!((filter.variance(5, 0), filter.variance(0, 2)), (None, None));
    assert_eq!(filter.fit().figures(), content.fit);
}

#[test]
fn each_count_is_checked() {
    let section = SectionKind::FilterCounts;
    let count = |at: usize, value: u32| edited(|pieces| pieces.set_word(section, at, value));
    for at in [0, 1] {
        let empty = FileError { expected: 1, ..error(Kind::Empty, section, at as u32) };
        assert_eq!(count(at, 0), Err(empty));
        let limit =
            FileError { expected: 65_535, found: 65_536, ..error(Kind::Limit, section, at as u32) };
        assert_eq!(count(at, 65_536), Err(limit));
    }
    assert_eq!(count(1, 4), Err(error(Kind::Invalid, section, 1)));
    let length = |expected| FileError {
        expected,
        found: 200,
        ..error(Kind::Length, SectionKind::FilterTaps, 0)
    };
    assert_eq!(count(1, 7), Err(length(4 * 7 * 2 * 7)));
    assert_eq!(count(0, 3), Err(length(4 * 5 * 3 * 5)));
}

#[test]
fn each_section_is_required_and_has_its_length() {
    for section in FILTER_SECTIONS {
        let missing = edited(|pieces| pieces.sections.retain(|own| own.kind != section.number()));
        match section {
            SectionKind::FilterVariances => assert_eq!(missing, Ok(())),
            _ => assert_eq!(missing, Err(error(Kind::Missing, section, 0))),
        }
        let longer = edited(|pieces| pieces.section(section).extend([0; 4]));
        let names = section == SectionKind::Names;
        let kind = if names { Kind::Invalid } else { Kind::Length };
        let refused = longer.unwrap_err();
        assert_eq!((refused.kind, refused.section), (kind, Some(section)));
    }
}

#[test]
fn each_float_is_checked() {
    for section in [SectionKind::FilterTaps, SectionKind::FilterVariances, SectionKind::FilterFit] {
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2.0e9] {
            let refused = edited(|pieces| pieces.set_float(section, 2, value));
            assert_eq!(refused, Err(error(Kind::Float, section, 2)), "{section:?} {value}");
        }
        let negative = edited(|pieces| pieces.set_float(section, 1, -1.0));
        match section {
            SectionKind::FilterTaps => assert_eq!(negative, Ok(())),
            _ => assert_eq!(negative, Err(error(Kind::Float, section, 1))),
        }
    }
}

#[test]
fn readers_that_do_not_know_the_kind_may_skip_it() {
    let skipped = edited(|pieces| {
        pieces.parts[0] = PartRow { kind: 77, flags: 0 };
        pieces.set_word(SectionKind::FilterCounts, 1, 4);
    });
    assert_eq!(skipped, Ok(()));
}
