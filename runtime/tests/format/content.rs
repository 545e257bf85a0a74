//! The content of sections: floats, indices, trees, frames, directions, names.

use crate::common::{envelope_error, exercise, skin_error};
use crate::format::{edited, error};
use models::{Content, Pieces, SMALL, STRETCHING, Shape, words};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::{PartRow, SectionKind};
use sinew_runtime::skin::{LENGTH_TOLERANCE, NO_ENVELOPE};
use sinew_runtime::{FileError, FileErrorKind as Kind, Model};

#[test]
fn each_float_is_checked() {
    let envelope = [
        (SectionKind::Certificate, 0),
        (SectionKind::InverseBinds, 0),
        (SectionKind::Keys, 1),
        (SectionKind::C1, 0),
        (SectionKind::C2, 0),
        (SectionKind::PoseRanges, 0),
        (SectionKind::HelperPlaces, 0),
    ];
    let skin = [
        SectionKind::RestPositions,
        SectionKind::RestNormals,
        SectionKind::RestTangents,
        SectionKind::InfluenceWeights,
        SectionKind::RestBoxes,
    ];
    let envelope =
        envelope.map(|(section, skipped)| (section, skipped, envelope_error(Kind::Float, section)));
    let skin = skin.map(|section| (section, 0, skin_error(Kind::Float, section)));
    for (section, skipped, error) in envelope.into_iter().chain(skin) {
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.1e9, -1.1e9] {
            let refused = edited(|b| b.set_float(section, 3, value));
            let expected = FileError { index: 3 - skipped, ..error };
            assert_eq!(refused, Err(expected), "{section:?} {value}");
        }
    }
    let negative = |section| edited(|b| b.set_float(section, 1, -0.25));
    for error in [
        skin_error(Kind::Float, SectionKind::InfluenceWeights),
        envelope_error(Kind::Float, SectionKind::PoseRanges),
    ] {
        assert_eq!(negative(error.section.unwrap()), Err(FileError { index: 1, ..error }));
    }
    for index in 0..8 {
        let refused = edited(|b| b.set_float(SectionKind::Certificate, index, f32::NAN));
        let error = envelope_error(Kind::Float, SectionKind::Certificate);
        assert_eq!(refused, Err(FileError { index: index as u32, ..error }));
    }
}

#[test]
fn the_spread_and_the_kind_of_helpers_are_checked() {
    let section = SectionKind::HelperPlaces;
    // Of helper 1: xx, yy, zz, then xy.
    for (at, value, is_right) in [
        (12, 0.01, true),
        (12, 0.009, false),
        (15, -0.5, false),
        (17, 0.0, false),
        (17, 2.0, true),
        (13, -2.0, true),
        (13, 2.1, false),
        (9, -1e9, true),
    ] {
        let found = edited(|b| b.set_float(section, at, value));
        let wrong = FileError { index: 1, ..envelope_error(Kind::Invalid, section) };
        assert_eq!(found, if is_right { Ok(()) } else { Err(wrong) }, "{at} {value}");
    }
    let kind = |predictor, kind| {
        let mut pieces = Pieces::small(predictor);
        pieces.set_word(SectionKind::EnvelopeCounts, 0, kind);
        Model::from_bytes(pieces.bytes()).map(|_| ()).map_err(|error| (error.section, error.index))
    };
    let refused = Err((Some(SectionKind::EnvelopeCounts), 0));
    assert_eq!([2, 3, 4].map(|number| kind(Predictor::Kernel, number)), [Ok(()); 3]);
    assert_eq!([0, 5].map(|number| kind(Predictor::Kernel, number)), [refused; 2]);
}

/// Loads a sample whose joints stretch after `edit`.
fn stretched(predictor: Predictor, edit: impl FnOnce(&mut Pieces)) -> Result<(), FileError> {
    let mut pieces = Pieces::sample(predictor, STRETCHING);
    edit(&mut pieces);
    Model::from_bytes(pieces.bytes()).map(|_| ())
}

#[test]
fn each_float_of_stretches_and_curves_is_checked() {
    let sections = [
        (Predictor::Rotational, SectionKind::StretchRanges, 4),
        (Predictor::Kernel, SectionKind::StretchRanges, 4),
        (Predictor::Rotational, SectionKind::KeyStretches, 3 * 36),
        (Predictor::Kernel, SectionKind::CurveRanges, 6),
    ];
    for (predictor, section, len) in sections {
        for index in [0, 3, len - 1] {
            let wrong = FileError { index: index as u32, ..envelope_error(Kind::Float, section) };
            for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.1e9, -1.1e9] {
                let refused = stretched(predictor, |b| b.set_float(section, index, value));
                assert_eq!(refused, Err(wrong), "{section:?} {value}");
            }
            // A range of strains is not negative.
            let negative = stretched(predictor, |b| b.set_float(section, index, -1e-3));
            let is_refused = negative == Err(wrong);
            assert_eq!(is_refused, section == SectionKind::StretchRanges, "{section:?} {index}");
        }
    }
}

#[test]
fn the_least_of_a_curve_is_not_above_its_greatest() {
    let section = SectionKind::CurveRanges;
    let set = |least, most| {
        stretched(Predictor::Kernel, |b| {
            b.set_float(section, 2, least);
            b.set_float(section, 3, most);
        })
    };
    let wrong = Err(FileError { index: 1, ..envelope_error(Kind::Invalid, section) });
    for (least, most) in [(0.0, 0.0), (-1.0, 1.0), (-2.0, -1.0), (3.0, 3.0f32.next_up())] {
        assert_eq!(set(least, most), Ok(()), "{least} {most}");
    }
    for (least, most) in [(1.0, 0.0), (3.0f32.next_up(), 3.0), (1.0, -1.0)] {
        assert_eq!(set(least, most), wrong, "{least} {most}");
    }
}

#[test]
fn stretches_and_curves_belong_to_their_predictors() {
    let counts =
        |kind, index| FileError { index, ..envelope_error(kind, SectionKind::EnvelopeCounts) };
    let section = SectionKind::EnvelopeCounts;
    for predictor in Predictor::ALL {
        for found in [2, 256, u32::MAX] {
            let refused = stretched(predictor, |b| b.set_word(section, 6, found));
            let expected = FileError { expected: 1, found, ..counts(Kind::Limit, 6) };
            assert_eq!(refused, Err(expected));
        }
        // The sections of stretches without the flag, and the flag without the sections.
        let ranges = envelope_error(Kind::Unexpected, SectionKind::StretchRanges);
        assert_eq!(stretched(predictor, |b| b.set_word(section, 6, 0)), Err(ranges));
        let missing = edited_of(predictor, |b| b.set_word(section, 6, 1));
        let ranges = envelope_error(Kind::Missing, SectionKind::StretchRanges);
        assert_eq!(missing, Err(ranges));
    }
    let curves = stretched(Predictor::Rotational, |b| b.set_word(section, 7, 1));
    assert_eq!(curves, Err(FileError { found: 1, ..counts(Kind::Limit, 7) }));
    let most = stretched(Predictor::Kernel, |b| b.set_word(section, 7, u32::MAX));
    let expected = FileError { expected: 4096, found: u32::MAX, ..counts(Kind::Limit, 7) };
    assert_eq!(most, Err(expected));
    // Another number of curves needs another length.
    let longer = stretched(Predictor::Kernel, |b| b.set_word(section, 7, 4));
    let expected = FileError {
        expected: 32,
        found: 24,
        ..envelope_error(Kind::Length, SectionKind::CurveRanges)
    };
    assert_eq!(longer, Err(expected));
    let phrase = curves.unwrap_err().to_string();
    assert_eq!(phrase, "part 0: curves: at most 0 allowed, found 1");
}

/// Loads a small sample after `edit`.
fn edited_of(predictor: Predictor, edit: impl FnOnce(&mut Pieces)) -> Result<(), FileError> {
    let mut pieces = Pieces::small(predictor);
    edit(&mut pieces);
    Model::from_bytes(pieces.bytes()).map(|_| ())
}

#[test]
fn each_tangent_coefficient_is_zero_or_normal() {
    let section = SectionKind::TangentCoefficients;
    let set = |bits| edited(|b| b.set_half(section, 5, bits));
    let wrong = Err(FileError { index: 5, ..skin_error(Kind::Float, section) });
    // Zeros, and the smallest and largest normal numbers, of both signs.
    for bits in [0, 0x8000, 0x0400, 0x8400, 0x3c00, 0x7bff, 0xfbff] {
        assert_eq!(set(bits), Ok(()), "{bits:#x}");
    }
    // Subnormal, infinite, and NaN.
    for bits in [0x0001, 0x8001, 0x03ff, 0x83ff, 0x7c00, 0xfc00, 0x7c01, 0x7e00, 0xffff] {
        assert_eq!(set(bits), wrong, "{bits:#x}");
    }
    let errors = SectionKind::NormalErrors;
    for (index, value) in [(0, f32::NAN), (1, f32::INFINITY), (1, -0.25)] {
        let refused = edited(|b| b.set_float(errors, index, value));
        let index = index as u32;
        assert_eq!(refused, Err(FileError { index, ..skin_error(Kind::Float, errors) }));
    }
}

#[test]
fn only_vertices_that_blend_have_tangent_coefficients() {
    let section = SectionKind::TangentCoefficients;
    let mut single = Pieces::sample(Predictor::Rotational, Shape { influences: 1, ..SMALL });
    assert!(exercise(&single.bytes()).is_some());
    single.sections.push(Content::new(section, 1, Vec::new()));
    assert_eq!(error_of(&single), skin_error(Kind::Unexpected, section));
    let mut loose = Pieces::loose(SMALL);
    loose.sections.push(Content::new(section, 0, Vec::new()));
    let unexpected = FileError { part: Some(0), ..skin_error(Kind::Unexpected, section) };
    assert_eq!(error_of(&loose), unexpected);
}

#[test]
fn each_index_is_checked() {
    let section = SectionKind::InfluenceIndices;
    let error = skin_error(Kind::Index, section);
    let refused = FileError { index: 5, expected: 3, found: 3, ..error };
    assert_eq!(edited(|b| b.set_half(section, 5, 3)), Err(refused));
    let section = SectionKind::Keys;
    let error = FileError { expected: 4, ..envelope_error(Kind::Index, section) };
    for joint in [0, 1] {
        let refused = FileError { index: 1, found: 4, ..error };
        assert_eq!(edited(|b| b.set_half(section, 110 + joint, 4)), Err(refused));
    }
    assert_eq!(
        edited(|b| b.set_half(section, 0, u16::MAX)),
        Err(FileError { found: 65_535, ..error }),
        "a key must have a joint"
    );
    let section = SectionKind::EnvelopeCounts;
    for found in [0, 5, 255, 257, u32::MAX] {
        let refused = FileError { found, ..envelope_error(Kind::Unsupported, section) };
        assert_eq!(edited(|b| b.set_word(section, 0, found)), Err(refused));
    }
}

#[test]
fn a_skin_follows_an_envelope_or_nothing() {
    let section = SectionKind::SkinCounts;
    let follow = |found| edited(|b| b.set_word(section, 2, found));
    assert_eq!(follow(0), Ok(()));
    // Itself, no part, and a number too large for a row.
    for found in [1, 2, 65_535, 65_536, u32::MAX - 1] {
        let refused =
            FileError { index: 2, expected: 2, found, ..skin_error(Kind::Index, section) };
        assert_eq!(follow(found), Err(refused));
    }
    // A part of an unknown kind, even if its sections are an envelope's.
    let skipped = edited(|b| {
        b.parts[0] = PartRow { kind: 9, flags: 0 };
    });
    let error = FileError { index: 2, expected: 2, ..skin_error(Kind::Index, section) };
    assert_eq!(skipped, Err(error));
    // No vertices but influences; and sections that only influences have.
    let refused = FileError { index: 1, found: 2, ..skin_error(Kind::Limit, section) };
    assert_eq!(follow(NO_ENVELOPE), Err(refused));
    let mut loose = Pieces::loose(SMALL);
    assert!(exercise(&loose.bytes()).is_some());
    loose.sections.push(Content::new(SectionKind::InfluenceWeights, 0, Vec::new()));
    let found = error_of(&loose);
    assert_eq!(
        (found.kind, found.section),
        (Kind::Unexpected, Some(SectionKind::InfluenceWeights))
    );
    // An envelope after its skin.
    let mut late = Pieces::several();
    late.parts.swap(0, 1);
    for content in &mut late.sections {
        content.part = [1, 0, 2, 3, 4][usize::from(content.part)];
    }
    late.set_word(section, 2, 1);
    exercise(&late.bytes()).unwrap();
    // The other envelope has a longer palette, which its skin's boxes and indices show.
    let mut other = Pieces::several();
    other.set_word(section, 2, 2);
    let found = error_of(&other);
    assert_eq!((found.kind, found.section), (Kind::Length, Some(SectionKind::RestBoxes)));
}

fn error_of(pieces: &Pieces) -> FileError {
    error(&pieces.bytes())
}

#[test]
fn the_hierarchy_is_one_tree() {
    let hierarchy = SectionKind::Hierarchy;
    let refused = |at, value| edited(|b| b.set_half(hierarchy, at, value));
    let wrong = |index| Err(FileError { index, ..envelope_error(Kind::Invalid, hierarchy) });
    // Parents of 0..4 are 2, none, 1, 0; the order is 1, 2, 0, 3; ranks are 2, 0, 1, 3.
    assert_eq!(refused(0, 3), wrong(0), "a cycle");
    assert_eq!(refused(0, 0), wrong(0), "its own parent");
    assert_eq!(refused(0, 4), wrong(0), "no such parent");
    assert_eq!(refused(0, u16::MAX), wrong(0), "a second root");
    assert_eq!(refused(1, 0), wrong(1), "no root");
    assert_eq!(refused(4, 2), wrong(2), "a joint twice");
    assert_eq!(refused(4, 9), wrong(4), "no such joint");
    assert_eq!(refused(8, 3), wrong(0), "a rank of another");
    let root = |root| edited(|b| b.set_word(SectionKind::EnvelopeCounts, 3, root));
    assert_eq!(root(2), wrong(1), "another root");
    assert_eq!(root(4), wrong(1), "no such root");
}

#[test]
fn inverse_binds_are_rigid() {
    let section = SectionKind::InverseBinds;
    let entry = |at: usize, value| edited(|b| b.set_float(section, 12 + at, value));
    let wrong = Err(FileError { index: 1, ..envelope_error(Kind::Invalid, section) });
    // Squares of diagonal entries, then a product of two rows.
    for (at, near, far) in
        [(0, 1.014, 1.016), (5, 0.986, 0.983), (10, 1.014, 1e9), (1, 0.029, 0.031)]
    {
        assert_eq!((entry(at, near), entry(at, far)), (Ok(()), wrong), "{at}");
    }
    assert_eq!(entry(10, -1.0), wrong, "mirrored");
    let turned = |rows: [[f32; 3]; 3]| {
        edited(|b| {
            for (at, value) in rows.as_flattened().iter().enumerate() {
                b.set_float(section, 12 + at / 3 * 4 + at % 3, *value);
            }
        })
    };
    assert_eq!(turned([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]), Ok(()));
    assert_eq!(turned([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), wrong, "mirrored");
    assert_eq!(turned([[0.0; 3]; 3]), wrong);
}

#[test]
fn normals_and_tangents_have_their_length() {
    let set = |section, vertex: usize, values: &[f32]| {
        edited(|b| {
            b.edit_vertices(section, |numbers| {
                let bytes: Vec<_> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
                numbers[bytes.len() * vertex..][..bytes.len()].copy_from_slice(&bytes);
            });
        })
    };
    let squared = |x: f32| (1.0 + x).sqrt();
    let within = [squared(0.9 * LENGTH_TOLERANCE), squared(-0.9 * LENGTH_TOLERANCE), 1.0];
    let beyond = [squared(1.2 * LENGTH_TOLERANCE), squared(-1.2 * LENGTH_TOLERANCE), 0.5, 2.0, 1e9];
    let normal = |n: [f32; 3]| set(SectionKind::RestNormals, 4, &n);
    let wrong = Err(FileError { index: 4, ..skin_error(Kind::Invalid, SectionKind::RestNormals) });
    within.into_iter().for_each(|x| assert_eq!(normal([0.0, -x, 0.0]), Ok(()), "{x}"));
    beyond.into_iter().for_each(|x| assert_eq!(normal([0.0, -x, 0.0]), wrong, "{x}"));
    assert_eq!(normal([0.6, 0.0, 0.8]), Ok(()));
    assert_eq!(normal([0.0, -0.0, 0.0]), Ok(()), "a vertex of no face has no normal");
    assert_eq!(normal([1e-6, 0.0, 0.0]), wrong);

    let tangent = |t: [f32; 4]| set(SectionKind::RestTangents, 6, &t);
    let wrong = Err(FileError { index: 6, ..skin_error(Kind::Invalid, SectionKind::RestTangents) });
    for hand in [1.0, -1.0] {
        within.into_iter().for_each(|x| assert_eq!(tangent([x, 0.0, 0.0, hand]), Ok(()), "{x}"));
        beyond.into_iter().for_each(|x| assert_eq!(tangent([x, 0.0, 0.0, hand]), wrong, "{x}"));
    }
    assert_eq!(tangent([0.0, 0.0, 0.0, 1.0]), wrong);
    for hand in [0.0, 0.5, 1.0_f32.next_up(), -2.0] {
        assert_eq!(tangent([1.0, 0.0, 0.0, hand]), wrong, "{hand}");
    }
}

#[test]
fn ranges_lie_inside_the_mesh_one_after_the_other() {
    let set = |rows: [u32; 4]| edited(|b| *b.section(SectionKind::Ranges) = words(&rows));
    let wrong = |index| Err(FileError { index, ..skin_error(Kind::Invalid, SectionKind::Ranges) });
    for sound in [[0, 3, 3, 7], [0, 0, 0, 0], [7, 7, 7, 7], [2, 3, 5, 6]] {
        assert_eq!(set(sound), Ok(()), "{sound:?}");
    }
    assert_eq!(set([3, 2, 4, 7]), wrong(0), "backwards");
    assert_eq!(set([0, 8, 8, 8]), wrong(0), "beyond the mesh");
    assert_eq!(set([0, u32::MAX, 4, 7]), wrong(0));
    assert_eq!(set([0, 3, 4, 8]), wrong(1), "beyond the mesh");
    assert_eq!(set([0, 3, 2, 7]), wrong(1), "two at once");
    assert_eq!(set([4, 7, 0, 3]), wrong(1), "out of order");
}

#[test]
fn names_weights_twists_and_boxes_are_checked() {
    for (part, at_text, last) in [(0, 4 * 5, 4), (1, 4 * 3, 2)] {
        let edited =
            |edit: &dyn Fn(&mut [u8])| edited(|b| edit(b.section_of(part, SectionKind::Names)));
        let error =
            FileError { part: Some(part), ..envelope_error(Kind::Invalid, SectionKind::Names) };
        let wrong = |index| Err(FileError { index, ..error });
        assert_eq!(edited(&|names| names[at_text] = 0xff), wrong(0), "not UTF-8");
        assert_eq!(edited(&|names| names[4] = 0), wrong(1), "backwards");
        assert_eq!(edited(&|names| names[4 * last as usize] = 200), wrong(last), "beyond");
    }

    let weight = |value| edited(|b| b.set_float(SectionKind::InfluenceWeights, 2, value));
    let wrong =
        Err(FileError { index: 2, ..skin_error(Kind::Invalid, SectionKind::InfluenceWeights) });
    assert_eq!(weight(0.75 + 9e-6), Ok(()));
    assert_eq!(weight(0.75 + 1.2e-5), wrong);
    assert_eq!(weight(0.75 - 1.2e-5), wrong);

    for at in [55 + 1, 55 + 10] {
        let twist = |value| edited(|b| b.set_float(SectionKind::Keys, at, value));
        let wrong = FileError { index: 1, ..envelope_error(Kind::Invalid, SectionKind::Keys) };
        assert_eq!(twist(1000.0), Ok(()));
        assert_eq!(twist(1025.0), Err(wrong));
    }
    let shrunk = edited(|b| b.set_float(SectionKind::RestBoxes, 3, -2.5));
    assert_eq!(shrunk, Err(skin_error(Kind::Invalid, SectionKind::RestBoxes)));
}
