//! Valid and invalid files of kernels.

use crate::common::{apart, exercise, file_error};
use models::{Content, KernelContent, Pieces, seal};
use sinew_runtime::format::{PartRow, SectionKind};
use sinew_runtime::kernel::{KERNEL_SECTIONS, Kernel, KernelRule, NO_TERM, OutputKind, QueryRule};
use sinew_runtime::{FileError, FileErrorKind as Kind, KernelMap, Model};

fn sample() -> KernelContent {
    KernelContent::every(Kernel::Wendland { l: 3 })
}

/// Loads the sample after `edit` has changed its plain lists.
fn with(edit: impl FnOnce(&mut KernelContent)) -> Result<(), FileError> {
    let mut content = sample();
    edit(&mut content);
    Model::from_bytes(Pieces::kernels(&[content]).bytes()).map(|_| ())
}

/// Loads the sample after `edit` has changed its bytes.
fn edited(edit: impl FnOnce(&mut Pieces)) -> Result<(), FileError> {
    let mut pieces = Pieces::kernels(&[sample()]);
    edit(&mut pieces);
    Model::from_bytes(pieces.bytes()).map(|_| ())
}

fn error(kind: Kind, section: SectionKind, index: u32) -> FileError {
    FileError { part: Some(0), section: Some(section), index, ..file_error(kind) }
}

/// Changes one byte of a section.
fn byte(section: SectionKind, at: usize, value: u8) -> Result<(), FileError> {
    edited(|pieces| pieces.section(section)[at] = value)
}

#[test]
fn sound_files_load_beside_other_parts() {
    let every = Kernel::ALL.map(KernelContent::every);
    exercise(&Pieces::kernels(&every).bytes()).unwrap();
    exercise(&Pieces::kernels(&[KernelContent::servo()]).bytes()).unwrap();
    let mut several = Pieces::several();
    several.append(Pieces::kernels(&[KernelContent::servo(), sample()]));
    exercise(&several.bytes()).unwrap();
    several.sections.reverse();
    let bytes = several.bytes();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let parts: Vec<_> = model.all::<KernelMap>().map(|map| (map.part(), map.name())).collect();
    assert_eq!(parts, [(5, "servo"), (6, "every")]);
}

#[test]
fn each_count_is_checked() {
    let section = SectionKind::KernelCounts;
    let count = |at: usize, value: u32| edited(|pieces| pieces.set_word(section, at, value));
    for at in 0..8 {
        for found in [65_536, u32::MAX] {
            let most = FileError { expected: 65_535, found, ..error(Kind::Limit, section, at) };
            assert_eq!(count(at as usize, found), Err(most));
        }
        let nothing = match at {
            0 | 1 | 2 | 6 => FileError { expected: 1, ..error(Kind::Empty, section, at) },
            3 => error(Kind::Unexpected, SectionKind::Metric, 0),
            7 => error(Kind::Unexpected, SectionKind::Variance, 0),
            _ => continue,
        };
        assert_eq!(count(at as usize, 0), Err(nothing), "{at}");
    }
    // With the largest counts no product overflows: the lengths are wrong.
    let all = edited(|pieces| (0..8).for_each(|at| pieces.set_word(section, at, 65_535)));
    assert_eq!(all.unwrap_err().kind, Kind::Length);
}

#[test]
fn each_section_is_required_and_has_its_length() {
    for section in KERNEL_SECTIONS {
        let without =
            edited(|pieces| pieces.sections.retain(|content| content.kind != section.number()));
        assert_eq!(without, Err(error(Kind::Missing, section, 0)));
        for change in [-1, 1] {
            let found = sample_bytes(section).wrapping_add_signed(change);
            let refused = edited(|pieces| pieces.section(section).resize(found, 0));
            if section == SectionKind::Names {
                assert_eq!(refused, Err(error(Kind::Invalid, section, 12)), "the last name");
                continue;
            }
            let (expected, found) = (sample_bytes(section) as u32, found as u32);
            let length = FileError { expected, found, ..error(Kind::Length, section, 0) };
            assert_eq!(refused, Err(length));
        }
    }
    // Without a metric or a variance their sections are not allowed.
    let bare = KernelContent::plain(Kernel::Cubic, [2, 3, 1]);
    for section in [SectionKind::Metric, SectionKind::Variance] {
        let mut pieces = Pieces::kernels(std::slice::from_ref(&bare));
        assert!(exercise(&pieces.bytes()).is_some());
        pieces.sections.push(Content::new(section, 0, Vec::new()));
        let refused = Model::from_bytes(pieces.bytes()).unwrap_err();
        assert_eq!(refused, error(Kind::Unexpected, section, 0));
    }
    // A required section of another kind of part.
    let joints =
        edited(|pieces| pieces.sections.push(Content::new(SectionKind::Keys, 0, vec![0; 4])));
    assert_eq!(joints.unwrap_err().kind, Kind::Unsupported);
}

fn sample_bytes(section: SectionKind) -> usize {
    Pieces::kernels(&[sample()]).section(section).len()
}

#[test]
fn each_float_is_checked() {
    // The words before the floats of an element, and the words of an element.
    let floats = [
        (SectionKind::KernelRule, 1, 3),
        (SectionKind::Inputs, 1, 4),
        (SectionKind::Outputs, 1, 7),
        (SectionKind::Features, 0, 1),
        (SectionKind::Metric, 0, 1),
        (SectionKind::KernelCentres, 0, 1),
        (SectionKind::KernelCoefficients, 0, 1),
        (SectionKind::Variance, 0, 1),
        (SectionKind::KernelFit, 0, 1),
    ];
    for (section, after, each) in floats {
        let words = sample_bytes(section) / 4;
        for word in (0..words)
            .filter(|word| word % each >= after)
            .step_by(apart(10_000).max(words / 50 + 1))
        {
            let index = (word - after - word / each * after) as u32;
            for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                let refused = edited(|pieces| pieces.set_float(section, word, value));
                assert_eq!(refused, Err(error(Kind::Float, section, index)), "{section:?} {word}");
            }
        }
    }
    // The largest floats are allowed: an overflow is an error of the call.
    let large = edited(|pieces| pieces.set_float(SectionKind::KernelCoefficients, 5, f32::MIN));
    assert_eq!(large, Ok(()));
}

#[test]
fn names_are_checked() {
    let refused = byte(SectionKind::Names, 4 * 13, 0xff);
    assert_eq!(refused, Err(error(Kind::Invalid, SectionKind::Names, 0)), "not UTF-8");
    let refused = byte(SectionKind::Names, 4, 0);
    assert_eq!(refused, Err(error(Kind::Invalid, SectionKind::Names, 1)), "backwards");
}

#[test]
fn the_rule_is_checked() {
    let section = SectionKind::KernelRule;
    let unknown = |number| Err(FileError { found: number, ..error(Kind::Unsupported, section, 0) });
    for kernel in [0, 14, 255] {
        assert_eq!(byte(section, 0, kernel as u8), unknown(kernel));
    }
    for parameter in [0, 1, 67, 255] {
        assert_eq!(byte(section, 1, parameter as u8), unknown(parameter), "no such Wendland");
    }
    assert_eq!(byte(section, 0, 8), unknown(3), "a gaussian has no parameter");
    for at in [2, 3] {
        assert_eq!(byte(section, at, 2), Ok(()));
        for number in [3, 255] {
            assert_eq!(byte(section, at, number as u8), unknown(number));
        }
    }
    let fade = |query, start, end| {
        with(|content| content.rule = KernelRule { query, fade: (start, end), ..content.rule })
    };
    let wrong = Err(error(Kind::Invalid, section, 0));
    for query in QueryRule::ALL {
        assert_eq!(fade(query, 0.0, 1e-45), Ok(()));
        let none = fade(query, 0.0, 0.0);
        assert_eq!(none, if query == QueryRule::Fade { wrong } else { Ok(()) });
        for (start, end) in [(1.0, 1.0), (2.0, 1.0), (-1.0, 1.0), (1.0, 0.0), (-1.0, -0.5)] {
            assert_eq!(fade(query, start, end), wrong, "{start} {end}");
        }
    }
}

#[test]
fn inputs_are_checked() {
    let section = SectionKind::Inputs;
    let unknown = |index, number| {
        Err(FileError { found: number, ..error(Kind::Unsupported, section, index) })
    };
    for (index, row) in (0..7).map(|index| (index, 16 * index as usize)) {
        for kind in [0, 8, 255] {
            assert_eq!(byte(section, row, kind as u8), unknown(index, kind));
        }
        assert_eq!(byte(section, row + 1, 6), Ok(()));
        for (at, number) in [(1, 7), (1, 255), (2, 1), (3, 128)] {
            assert_eq!(byte(section, row + at, number as u8), unknown(index, number));
        }
        let axis = |x: f32| with(|content| content.inputs[index as usize].1.axis = [0.0, x, 0.0]);
        let wrong = Err(error(Kind::Invalid, section, index));
        let has_axis = index >= 4;
        assert_eq!(axis(0.0), if has_axis { wrong } else { Ok(()) });
        assert_eq!(axis(1.0), if has_axis { Ok(()) } else { wrong });
        assert_eq!(axis(-1.000_004), if has_axis { Ok(()) } else { wrong });
        assert_eq!((axis(1.000_01), axis(0.5)), (wrong, wrong));
    }
    // A kind with other features: the sum no longer agrees with the count.
    let counts = SectionKind::KernelCounts;
    let mismatch = FileError { expected: 27, found: 25, ..error(Kind::Mismatch, counts, 2) };
    assert_eq!(byte(section, 0, 2), Err(mismatch));
    assert_eq!(mismatch.to_string(), "part 0: features: the rows need 27, found 25");
}

#[test]
fn outputs_are_checked() {
    let section = SectionKind::Outputs;
    let unknown = |index, number| {
        Err(FileError { found: number, ..error(Kind::Unsupported, section, index) })
    };
    let wrong = |index| Err(error(Kind::Invalid, section, index));
    for (index, row) in (0..5).map(|index| (index, 28 * index as usize)) {
        for (at, number) in [(0, 0), (0, 4), (0, 255), (1, 2), (2, 1), (3, 1)] {
            assert_eq!(byte(section, row + at, number as u8), unknown(index, number));
        }
        let marked = byte(section, row + 1, 1);
        assert_eq!(
            marked,
            if index < 3 { Ok(()) } else { wrong(index) },
            "scalars alone are marked"
        );
        let range =
            |low, high| with(|content| content.outputs[index as usize].1.range = (low, high));
        assert_eq!(range(-1.0, 1.0), if index < 3 { Ok(()) } else { wrong(index) });
        assert_eq!(range(0.0, 0.0), Ok(()));
        assert_eq!(range(1.0, -1.0), wrong(index));
        for at in 0..4 {
            let neutral = with(|content| content.outputs[index as usize].1.neutral[at] += 0.125);
            let own = [1, 1, 1, 3, 0][index as usize];
            assert_eq!(neutral, if at < own { Ok(()) } else { wrong(index) }, "{index} {at}");
        }
    }
    let counts = SectionKind::KernelCounts;
    let mismatch = FileError { expected: 11, found: 9, ..error(Kind::Mismatch, counts, 6) };
    let other = with(|content| {
        let output = &mut content.outputs[0].1;
        (output.kind, output.range) = (OutputKind::Vector3, (0.0, 0.0));
    });
    assert_eq!(other, Err(mismatch));
}

#[test]
fn features_and_terms_are_checked() {
    let range = |low, high| with(|content| content.features[4] = [0.0, 1.0, low, high]);
    assert_eq!((range(-1.0, 1.0), range(2.0, 2.0)), (Ok(()), Ok(())));
    assert_eq!(range(2.0, 1.999_999), Err(error(Kind::Invalid, SectionKind::Features, 4)));

    let section = SectionKind::Terms;
    let term = |at: usize, term: [u16; 2]| with(|content| content.terms[at] = term);
    for first in [[0, NO_TERM], [NO_TERM, 0], [0, 0]] {
        assert_eq!(term(0, first), Err(error(Kind::Invalid, section, 0)));
    }
    let index =
        |at, expected, found| Err(FileError { expected, found, ..error(Kind::Index, section, at) });
    assert_eq!(term(5, [4, 24]), Ok(()));
    assert_eq!(term(5, [5, 24]), index(10, 5, 5), "itself");
    assert_eq!(term(5, [NO_TERM, 24]), index(10, 5, 65_535));
    assert_eq!(term(5, [4, 25]), index(11, 25, 25));
    assert_eq!(term(5, [4, NO_TERM]), index(11, 25, 65_535));
}

#[test]
fn a_reader_may_skip_a_kernel_that_need_not_be_known() {
    // An older reader does not know kernels, as this reader does not know this kind.
    let mut pieces = Pieces::kernels(&[sample()]);
    pieces.parts[0] = PartRow { kind: 99, flags: 0 };
    let model = Model::from_bytes(pieces.bytes()).unwrap();
    assert!(model.first::<KernelMap>().is_none() && model.parts().len() == 1);
    pieces.parts[0].flags = 1;
    assert_eq!(Model::from_bytes(pieces.bytes()).unwrap_err().kind, Kind::Unsupported);
}

#[test]
fn damage_is_refused_or_harmless() {
    let bytes = Pieces::kernels(&[sample()]).bytes();
    let (mut loaded, mut refused) = (0, 0);
    for at in (0..bytes.len()).step_by(apart(1_999).max(7)) {
        for flip in [1, 0x10, 0x80] {
            let mut damaged = bytes.clone();
            damaged[at] ^= flip;
            seal(&mut damaged);
            match exercise(&damaged) {
                Some(()) => loaded += 1,
                None => refused += 1,
            }
        }
    }
    assert!(cfg!(miri) || loaded > 500 && refused > 10, "{loaded} {refused}");
}

#[test]
fn errors_say_what_is_wrong_in_a_phrase() {
    let phrase = |refused: Result<(), FileError>| refused.unwrap_err().to_string();
    assert_eq!(
        phrase(edited(|pieces| pieces.set_word(SectionKind::KernelCounts, 4, 70_000))),
        "part 0: centres: at most 65535 allowed, found 70000"
    );
    assert_eq!(
        phrase(edited(|pieces| pieces.set_word(SectionKind::KernelCounts, 6, 0))),
        "part 0: values: expected at least 1, found 0"
    );
    assert_eq!(
        phrase(with(|content| content.rule.fade = (2.0, 1.0))),
        "part 0: the fade does not start and end"
    );
    assert_eq!(
        phrase(with(|content| content.inputs[5].1.axis = [0.0; 3])),
        "part 0: the axis of input 5 has a wrong length"
    );
    assert_eq!(
        phrase(with(|content| content.outputs[4].1.neutral = [0.0; 4])),
        "part 0: the range or the neutral of output 4 does not fit its kind"
    );
}
