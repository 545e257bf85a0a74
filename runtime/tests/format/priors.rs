//! Valid and invalid files of priors.

use crate::common::{exercise, file_error};
use models::{Pieces, PriorContent};
use sinew_runtime::format::{PartRow, SectionKind};
use sinew_runtime::prior::PRIOR_SECTIONS;
use sinew_runtime::{FileError, FileErrorKind as Kind, Limits, Model, Prior};

/// Loads a face after `edit` has changed its prior in plain lists.
fn with(edit: impl FnOnce(&mut PriorContent)) -> Result<(), FileError> {
    let mut content = PriorContent::sample(0, 8);
    edit(&mut content);
    let [.., mut pieces] = Pieces::shaped();
    pieces.add_prior(&content);
    Model::from_bytes(pieces.bytes()).map(|_| ())
}

/// Loads a face after `edit` has changed its bytes.
fn edited(edit: impl FnOnce(&mut Pieces)) -> Result<(), FileError> {
    let mut pieces = Pieces::face();
    edit(&mut pieces);
    Model::from_bytes(pieces.bytes()).map(|_| ())
}

fn error(kind: Kind, section: SectionKind, index: u32) -> FileError {
    FileError { part: Some(1), section: Some(section), index, ..file_error(kind) }
}

#[test]
fn sound_files_load_beside_other_parts() {
    exercise(&Pieces::face().bytes()).unwrap();
    let mut several = Pieces::several();
    several.append(Pieces::face());
    several.add_prior(&PriorContent { name: "other".to_owned(), ..PriorContent::sample(5, 8) });
    several.sections.reverse();
    let bytes = several.bytes();
    exercise(&bytes).unwrap();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let found: Vec<_> = model.all::<Prior>().map(|prior| (prior.part(), prior.name())).collect();
    assert_eq!(found, [(6, "prior"), (7, "other")]);
    assert_eq!(model.skin_of(&model.named::<Prior>("other").unwrap()).unwrap().part(), 5);
}

#[test]
fn accessors_give_what_was_written() {
    let content = PriorContent::sample(0, 8);
    let bytes = Pieces::face().bytes();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let prior = model.first::<Prior>().unwrap().layout().open::<Prior>(&bytes).unwrap();
    assert_eq!(model.skin_of(&prior).unwrap().part(), 0);
    assert_eq!((0..9).map_while(|s| prior.mean(s)).collect::<Vec<_>>(), content.mean);
    assert_eq!((0..9).map_while(|s| prior.weight_bounds(s)).collect::<Vec<_>>(), content.bounds);
    for (i, row) in content.factor.iter().enumerate() {
        for j in 0..8 {
            let expected = if j < i { 0.0 } else { row[j - i] };
            assert_eq!(prior.factor_entry(i, j), Some(expected));
        }
        assert_eq!((prior.factor_entry(i, 8), prior.factor_entry(8, i)), (None, None));
    }
    assert_eq!(prior.symmetry().collect::<Vec<_>>(), [([0, 1], 2.5)]);
    assert_eq!(prior.cancel_pairs().collect::<Vec<_>>(), [[3, 2]]);
    assert_eq!(prior.fit().figures(), content.fit);
}

#[test]
fn each_count_is_checked() {
    let section = SectionKind::PriorCounts;
    let count = |at: usize, value: u32| edited(|pieces| pieces.set_word(section, at, value));
    for found in [1, 2, 65_536, u32::MAX] {
        let index = FileError { expected: 2, found, ..error(Kind::Index, section, 0) };
        assert_eq!(count(0, found), Err(index));
    }
    assert_eq!(count(1, 0), Err(FileError { expected: 1, ..error(Kind::Empty, section, 1) }));
    let most = FileError { expected: 4096, found: 4097, ..error(Kind::Limit, section, 1) };
    assert_eq!(count(1, 4097), Err(most));
    let other = FileError { expected: 8, found: 7, ..error(Kind::Mismatch, section, 1) };
    assert_eq!(count(1, 7), Err(other));
    let limits = Limits { shapes: 7, ..Limits::DEFAULT };
    let refused = Model::from_bytes_with(Pieces::face().bytes(), &limits).map(|_| ()).unwrap_err();
    assert_eq!((refused.kind, refused.found), (Kind::Limit, 8));
    for (at, section, each) in [(2, SectionKind::Symmetry, 8), (3, SectionKind::CancelPairs, 4)] {
        let length =
            FileError { expected: 2 * each, found: each, ..error(Kind::Length, section, 0) };
        assert_eq!(count(at, 2), Err(length));
    }
}

#[test]
fn each_section_is_required_and_has_its_length() {
    for section in PRIOR_SECTIONS {
        let is_it =
            |content: &models::Content| (content.part, content.kind) == (1, section.number());
        let missing = edited(|pieces| pieces.sections.retain(|content| !is_it(content)));
        assert_eq!(missing, Err(error(Kind::Missing, section, 0)));
        let longer = edited(|pieces| pieces.section_of(1, section).extend([0; 4]));
        let refused = longer.unwrap_err();
        let names = section == SectionKind::Names;
        let kind = if names { Kind::Invalid } else { Kind::Length };
        assert_eq!((refused.kind, refused.section), (kind, Some(section)));
    }
}

#[test]
fn each_float_is_checked() {
    // The word of the first float.
    for (section, at) in [
        (SectionKind::PriorMean, 0),
        (SectionKind::PriorFactor, 0),
        (SectionKind::WeightBounds, 0),
        (SectionKind::Symmetry, 1),
        (SectionKind::PriorFit, 0),
    ] {
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2.0e9] {
            let refused = edited(|pieces| pieces.set_float(section, at, value));
            assert_eq!(refused, Err(error(Kind::Float, section, 0)), "{section:?} {value}");
        }
    }
    let negative = edited(|pieces| pieces.set_float(SectionKind::PriorFit, 2, -1.0));
    assert_eq!(negative, Err(error(Kind::Float, SectionKind::PriorFit, 2)));
}

#[test]
fn the_factor_is_checked() {
    let section = SectionKind::PriorFactor;
    for value in [0.0, -0.0, -1.0, 1e-30] {
        let found = with(|prior| prior.factor[0][0] = value);
        // A small diagonal without other entries in its column is only a small precision.
        let expected = if value > 0.0 { Ok(()) } else { Err(error(Kind::Invalid, section, 0)) };
        assert_eq!(found, expected);
        // The fourth row starts after 8 + 7 + 6 numbers.
        let found = with(|prior| prior.factor[3][0] = value);
        assert_eq!(found, Err(error(Kind::Invalid, section, 21)), "{value}");
    }
    // In a column of 1 and x, the share 1e-10 of the sum of squares is reached at x = 1e-5.
    for (x, is_sound) in [(1.001e-5, true), (0.999e-5, false)] {
        let found = with(|prior| {
            prior.factor[0][1] = 1.0;
            prior.factor[1][0] = x;
        });
        assert_eq!(found.is_ok(), is_sound, "{x}");
    }
}

#[test]
fn bounds_pairs_and_beta_are_checked() {
    let section = SectionKind::WeightBounds;
    assert_eq!(with(|prior| prior.bounds[5] = [0.5, 0.4]), Err(error(Kind::Invalid, section, 5)));
    assert_eq!(with(|prior| prior.bounds[5] = [0.5, 0.5]), Ok(()));

    let section = SectionKind::Symmetry;
    let pair = |pair, stiffness| with(|prior| prior.symmetry.push((pair, stiffness)));
    let beyond = FileError { expected: 8, found: 8, ..error(Kind::Index, section, 1) };
    assert_eq!(pair([2, 8], 1.0), Err(beyond));
    assert_eq!(pair([8, 2], 1.0), Err(beyond));
    assert_eq!(pair([2, 2], 1.0), Err(error(Kind::Invalid, section, 1)));
    assert_eq!(pair([2, 3], -1.0), Err(error(Kind::Invalid, section, 1)));
    assert_eq!(pair([2, 3], 0.0), Ok(()));

    let section = SectionKind::CancelPairs;
    let pair = |pair| with(|prior| prior.cancel.push(pair));
    let beyond = FileError { expected: 8, found: 9, ..error(Kind::Index, section, 1) };
    assert_eq!(pair([9, 1]), Err(beyond));
    assert_eq!(pair([4, 4]), Err(error(Kind::Invalid, section, 1)));
    assert_eq!(pair([4, 5]), Ok(()));
    for bounds in [[0.1, 1.0], [-1.0, -0.1]] {
        let found = with(|prior| prior.bounds[2] = bounds);
        assert_eq!(found, Err(error(Kind::Invalid, section, 0)));
    }

    let found = with(|prior| prior.fit[0] = 0.0);
    assert_eq!(found, Err(error(Kind::Invalid, SectionKind::PriorFit, 0)));
}

#[test]
fn a_reader_may_skip_a_prior_that_need_not_be_known() {
    let unknown = |flags| {
        edited(|pieces| {
            pieces.parts[1] = PartRow { kind: 99, flags };
            pieces.sections.iter_mut().for_each(|content| content.flags = 0);
        })
    };
    assert_eq!(unknown(0), Ok(()));
    assert_eq!(unknown(1).unwrap_err().kind, Kind::Unsupported);
}

#[test]
fn errors_say_what_is_wrong_in_a_phrase() {
    let text = |found: Result<(), FileError>| found.unwrap_err().to_string();
    assert_eq!(
        text(with(|prior| prior.mean.push(0.0))),
        "part 1: shapes: the skins need 8, found 9"
    );
    assert_eq!(
        text(with(|prior| prior.factor[0][0] = 0.0)),
        "part 1: float 0 of prior_factor is too small for the diagonal of its column"
    );
    assert_eq!(
        text(with(|prior| prior.bounds[1] = [1.0, 0.0])),
        "part 1: the bounds of weight 1 end before they start"
    );
    assert_eq!(
        text(with(|prior| prior.cancel[0] = [1, 1])),
        "part 1: pair 0 of cancel_pairs is of one shape, or of one that cannot be 0"
    );
    assert_eq!(
        text(with(|prior| prior.symmetry[0].0 = [1, 1])),
        "part 1: pair 0 of symmetry is of one shape, or its stiffness negative"
    );
    assert_eq!(text(with(|prior| prior.fit[0] = 0.0)), "part 1: pins have no stiffness: beta is 0");
}
