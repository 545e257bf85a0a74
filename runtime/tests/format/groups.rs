//! Valid and invalid files of kernel models.

use crate::common::{apart, envelope_error, exercise};
use crate::format::error;
use models::{GroupContent, JOINTLESS, Pieces, Rng, SMALL, STRETCHING, Shape, sample_groups, seal};
use sinew_runtime::envelope::{GroupConfidence, GroupKernel, GroupRow, Predictor};
use sinew_runtime::format::{CORRECTION_MAX, SectionKind};
use sinew_runtime::{Envelope, FileError, FileErrorKind as Kind, Limits, Model};

/// Loads a kernel sample after `edit`.
fn edited(edit: impl Fn(&mut Pieces)) -> Result<(), FileError> {
    let mut pieces = Pieces::small(Predictor::Kernel);
    edit(&mut pieces);
    Model::from_bytes(pieces.bytes()).map(|_| ())
}

fn counts(kind: Kind, index: u32) -> FileError {
    FileError { index, ..envelope_error(kind, SectionKind::EnvelopeCounts) }
}

fn row(edit: impl Fn(&mut GroupRow)) -> Result<(), FileError> {
    edited(|b| b.edit_group(1, &edit))
}

#[test]
fn accessors_give_what_was_written() {
    let groups = sample_groups(SMALL);
    assert_eq!(groups.len(), 2);
    let model = Model::from_bytes(Pieces::small(Predictor::Kernel).bytes()).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    assert_eq!((envelope.predictor(), envelope.group_len()), (Predictor::Kernel, 2));
    assert_eq!(envelope.palette_len(), 4 + 3);
    // 8 (B(d) + B(n) + B(r) + B(12 p)): the first group 8 + 16 + 8 + 16, the second
    // 16 + 8 + 8 + 24.
    assert_eq!(envelope.correction_len(), 56);
    assert_eq!(envelope.scratch_len(), 12 * 4 + 56);
    assert_eq!(envelope.origin(0), Some([2.0, 0.0, 0.0]));
    assert_eq!((envelope.origin(4), envelope.key(0)), (None, None));
    let mut start = 0;
    for (index, expected) in groups.iter().enumerate() {
        let found = envelope.group(index).unwrap();
        assert_eq!((found.joint, found.kernel), (expected.joint, expected.kernel));
        assert_eq!(found.proxies, start..start + expected.proxies);
        assert_eq!(
            (found.confidence, found.certainty_len()),
            (expected.confidence, expected.certainty)
        );
        start = found.proxies.end;
        let (d, n) = (found.input_len(), found.centre_len());
        let inputs = (0..d).map(|i| found.input(i).unwrap());
        assert!(inputs.eq(expected.inputs.iter().map(|&(f, w)| (f as usize, w))));
        let centres = (0..n).map(|k| (0..d).map(|i| found.centre(k, i).unwrap()).collect());
        assert_eq!(centres.collect::<Vec<Vec<_>>>(), expected.centres);
        let rest = (0..n).map(|k| found.rest(k).unwrap());
        assert_eq!(rest.collect::<Vec<_>>(), expected.rest());
        let list = |columns: usize, entry: &dyn Fn(usize) -> Option<f32>| {
            (0..columns).map(|column| entry(column).unwrap()).collect::<Vec<_>>()
        };
        for (r, expected) in expected.coefficients.iter().enumerate() {
            assert_eq!(&list(n + d, &|c| found.coefficient(r, c)), expected);
        }
        for (o, expected) in expected.outputs.iter().enumerate() {
            assert_eq!(&list(found.rank(), &|c| found.output(o, c)), expected);
        }
        assert_eq!((found.input(d), found.centre(n, 0), found.centre(0, d)), (None, None, None));
        assert_eq!((found.rest(n), found.coefficient(0, n + d)), (None, None));
        assert_eq!((found.output(12 * expected.proxies, 0)), None);
    }
    assert!(envelope.group(2).is_none());
}

#[test]
fn a_model_of_joints_alone_loads() {
    let shape = Shape { proxies: 0, ..SMALL };
    let bytes = Pieces::sample(Predictor::Kernel, shape).bytes();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    assert_eq!((envelope.palette_len(), envelope.correction_len()), (4, 0));
    exercise(&bytes).unwrap();
    let mut pieces = Pieces::small(Predictor::Rotational);
    pieces.set_word(SectionKind::EnvelopeCounts, 2, 0);
    let empty = FileError { expected: 1, ..counts(Kind::Empty, 2) };
    assert_eq!(Model::from_bytes(pieces.bytes()).err(), Some(empty));
}

#[test]
fn every_truncation_and_every_changed_byte_is_harmless() {
    let shape = Shape {
        vertices: 1,
        joints: 2,
        proxies: 2,
        influences: 1,
        tangents: false,
        coefficients: false,
        ..SMALL
    };
    let mut pieces = Pieces::sample(Predictor::Kernel, shape);
    let mut rng = Rng(5);
    let group = |rng: &mut Rng, sizes| GroupContent::sample(rng, shape, 1, sizes);
    pieces.set_groups(&[group(&mut rng, [3, 2, 2]), group(&mut rng, [1, 3, 1])]);
    let bytes = pieces.bytes();
    exercise(&bytes).unwrap();
    for len in (0..bytes.len()).step_by(apart(199)) {
        let mut short = bytes[..len].to_vec();
        assert_eq!(error(&short).kind, Kind::Truncated, "{len}");
        seal(&mut short);
        assert!(exercise(&short).is_none(), "{len}");
    }
    let mut loaded = 0;
    for at in (0..bytes.len()).step_by(apart(299)) {
        for change in [1, 2, 0x10, 0x40, 0x80, 0xff] {
            let mut changed = bytes.clone();
            changed[at] ^= change;
            assert!(Model::from_bytes(&changed).is_err(), "{at}");
            seal(&mut changed);
            loaded += usize::from(exercise(&changed).is_some());
        }
    }
    // Mostly low bits of floats. Control: the second half of the test has evaluated files.
    assert!(loaded > bytes.len() / apart(299), "{loaded}");
}

#[test]
fn each_field_of_a_group_is_checked() {
    assert_eq!(row(|_| {}), Ok(()));
    let section = SectionKind::Groups;
    let group = |kind| FileError { index: 1, ..envelope_error(kind, section) };
    let index = FileError { expected: 4, found: 4, ..group(Kind::Index) };
    assert_eq!(row(|r| r.joint = 4), Err(index));
    let unknown = |found| Err(FileError { found, ..group(Kind::Unsupported) });
    for kernel in [0, 1, 7, 12, 15, 16 + GroupKernel::ALL[0].number(), 255] {
        assert_eq!(row(|r| r.kernel = kernel), unknown(kernel.into()));
    }
    for kernel in GroupKernel::ALL {
        assert_eq!(row(|r| r.kernel = kernel.number()), Ok(()));
    }
    let empty = FileError { expected: 1, ..group(Kind::Empty) };
    for edit in [(|r| r.proxy_len = 0) as fn(&mut GroupRow), |r| r.input_len = 0, |r| r.rank = 0] {
        assert_eq!(row(edit), Err(empty));
    }
    let expected = sample_groups(SMALL)[0].words().len() as u32 / 4;
    for found in [0, expected - 8, expected + 1, u32::MAX] {
        let offset = FileError { expected, found, ..group(Kind::Mismatch) };
        assert_eq!(row(|r| r.offset = found), Err(offset));
    }
    let late = edited(|b| b.edit_group(0, |r| r.offset = 8));
    assert_eq!(late, Err(FileError { found: 8, ..envelope_error(Kind::Mismatch, section) }));
    let proxies = |expected| Err(FileError { expected, found: 3, ..counts(Kind::Mismatch, 2) });
    assert_eq!(row(|r| r.proxy_len = 3), proxies(4));
    assert_eq!(row(|r| r.proxy_len = 1), proxies(2));
    // Another size needs another length.
    for edit in [
        (|r| r.input_len += 8) as fn(&mut GroupRow),
        |r| r.centre_len += 8,
        |r| r.rank += 8,
        |r| r.certainty_len += 8,
        |r| (r.input_len, r.centre_len, r.rank) = (u16::MAX, u16::MAX, u16::MAX),
    ] {
        let refused = row(edit).unwrap_err();
        let length = envelope_error(Kind::Length, SectionKind::Corrections);
        assert_eq!(FileError { expected: 0, found: 0, ..refused }, length);
    }
    for found in [0, 55, 57, u32::MAX] {
        let scratch = FileError { expected: 56, found, ..counts(Kind::Mismatch, 5) };
        assert_eq!(edited(|b| b.set_word(SectionKind::EnvelopeCounts, 5, found)), Err(scratch));
    }
    let many = FileError { expected: 3, found: 4, ..counts(Kind::Limit, 4) };
    assert_eq!(edited(|b| b.set_word(SectionKind::EnvelopeCounts, 4, 4)), Err(many));
}

#[test]
fn a_rotational_model_has_no_groups_and_no_scratch() {
    let refused = |at: usize| {
        let mut pieces = Pieces::small(Predictor::Rotational);
        pieces.set_word(SectionKind::EnvelopeCounts, at, 1);
        Model::from_bytes(pieces.bytes()).unwrap_err()
    };
    assert_eq!(refused(4), FileError { found: 1, ..counts(Kind::Limit, 4) });
    assert_eq!(refused(5), FileError { found: 1, ..counts(Kind::Mismatch, 5) });
    // More groups than the format has proxies for are refused before they cost anything.
    let mut pieces = Pieces::small(Predictor::Kernel);
    pieces.set_word(SectionKind::EnvelopeCounts, 2, u32::MAX);
    pieces.set_word(SectionKind::EnvelopeCounts, 4, u32::MAX);
    let unlimited = Limits { proxies: u32::MAX, ..Limits::DEFAULT };
    let found = Model::from_bytes_with(pieces.bytes(), &unlimited).map(|_| ());
    let expected = FileError { expected: 65_535, found: u32::MAX, ..counts(Kind::Limit, 2) };
    assert_eq!(found.unwrap_err(), expected);
}

#[test]
fn confidence_numbers_are_finite_and_not_negative() {
    let wrong = Err(FileError { index: 1, ..envelope_error(Kind::Invalid, SectionKind::Groups) });
    let confidence = |reach, linear, signal, noise| {
        row(|r| r.confidence = GroupConfidence { reach, linear, signal, noise })
    };
    let most = CORRECTION_MAX;
    assert_eq!(confidence(1e-45, 0.0, 0.0, 0.0), Ok(()));
    assert_eq!(confidence(most, most, most, most), Ok(()));
    assert_eq!(confidence(0.0, 1.0, 1.0, 1.0), wrong);
    for bad in [-1e-9, 1.1 * most, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for place in 0..4 {
            let [a, b, c, d] = [0, 1, 2, 3].map(|at| if at == place { bad } else { 1.0 });
            assert_eq!(confidence(a, b, c, d), wrong, "{bad} at {place}");
        }
    }
    // Without centres the confidence is 0, but the numbers must still be valid.
    let without = |reach, noise| {
        edited(|b| {
            let mut groups = sample_groups(SMALL);
            groups[1].centres.clear();
            groups[1].inputs.clear();
            groups[1].certainty = 0;
            groups[1].coefficients = vec![Vec::new()];
            groups[1].confidence = GroupConfidence { reach, noise, ..GroupConfidence::default() };
            b.set_groups(&groups);
        })
    };
    assert_eq!(without(0.0, 0.0), Ok(()));
    assert_eq!(without(0.0, f32::NAN), wrong);
}

#[test]
fn each_number_of_a_correction_is_checked() {
    let section = SectionKind::Corrections;
    let len = Pieces::small(Predictor::Kernel).section(section).len() / 4;
    let groups = sample_groups(SMALL);
    let first = groups[0].words().len() / 4;
    // Features come first in each group, 5 and then 9 in whole blocks.
    let feature = |at: usize| at < 8 || (first..first + 16).contains(&at);
    for index in (0..len).step_by(apart(97)) {
        if feature(index) {
            for found in [48, u32::MAX] {
                let refused = edited(|b| b.set_float(section, index, f32::from_bits(found)));
                let error = envelope_error(Kind::Index, section);
                let index = index as u32;
                assert_eq!(refused, Err(FileError { index, expected: 48, found, ..error }));
            }
            assert_eq!(edited(|b| b.set_float(section, index, f32::from_bits(47))), Ok(()));
            continue;
        }
        let limit = CORRECTION_MAX;
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.001 * limit, -1.001 * limit] {
            let refused = edited(|b| b.set_float(section, index, value));
            let index = index as u32;
            assert_eq!(refused, Err(FileError { index, ..envelope_error(Kind::Float, section) }));
        }
        assert_eq!(edited(|b| b.set_float(section, index, -limit)), Ok(()));
    }
    for value in [f32::NAN, 1.1e9] {
        let refused = edited(|b| b.set_float(SectionKind::Origins, 7, value));
        let error = envelope_error(Kind::Float, SectionKind::Origins);
        assert_eq!(refused, Err(FileError { index: 7, ..error }));
    }
}

#[test]
fn inputs_may_be_strains_and_curves() {
    let section = SectionKind::Corrections;
    for (shape, features) in [(STRETCHING, 12 * 4 + 6 * 4 + 3), (JOINTLESS, 5)] {
        let set = |feature: u32| {
            let mut pieces = Pieces::sample(Predictor::Kernel, shape);
            pieces.set_word(section, 2, feature);
            Model::from_bytes(pieces.bytes()).map(|_| ())
        };
        assert_eq!(set(features - 1), Ok(()));
        for found in [features, u32::MAX] {
            let error = envelope_error(Kind::Index, section);
            assert_eq!(set(found), Err(FileError { index: 2, expected: features, found, ..error }));
        }
    }
}

#[test]
fn errors_say_what_is_wrong_in_a_phrase() {
    let phrase = |refused: Result<(), FileError>| refused.unwrap_err().to_string();
    assert_eq!(phrase(row(|r| r.kernel = 3)), "part 0: element 1 of groups: unknown number 3");
    assert_eq!(
        phrase(edited(|b| b.set_word(SectionKind::EnvelopeCounts, 5, 9))),
        "part 0: floats of scratch: the groups need 56, found 9"
    );
    let offset = phrase(edited(|b| b.edit_group(0, |r| r.offset = 8)));
    assert_eq!(offset, "part 0: group 0: expected at word 0, found at 8");
}
