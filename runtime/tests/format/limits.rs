//! The caller's limits, and the limits of the format.

use crate::common::{envelope_error, file_error, skin_error};
use crate::format::edited;
use models::{Content, Pieces, SMALL, STRETCHING, Shape, ShapeContent};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::{Element, PartRow, SectionKind};
use sinew_runtime::{FileError, FileErrorKind as Kind, Limits, Model};

#[test]
fn limits_are_honoured() {
    let mut pieces = Pieces::several();
    pieces.set_shapes(&ShapeContent::sample(Element::I8, 3, SMALL.vertices));
    let bytes = pieces.bytes();
    let exact = Limits {
        file_bytes: bytes.len() as u32,
        parts: 5,
        sections: 10 + 11 + 10 + 11 + 7 + 6,
        vertices: SMALL.vertices as u32,
        joints: SMALL.joints as u32,
        proxies: SMALL.proxies as u32,
        influences: SMALL.influences as u32,
        shapes: 3,
        curves: 0,
    };
    assert!(Model::from_bytes_with(&bytes, &exact).is_ok());
    let refused = |limits: Limits, error: FileError, most| {
        let found = Model::from_bytes_with(&bytes, &limits).unwrap_err();
        assert_eq!(found, FileError { expected: most, found: most + 1, ..error });
    };
    let whole = |index| FileError { index, ..file_error(Kind::Limit) };
    let envelope =
        |index| FileError { index, ..envelope_error(Kind::Limit, SectionKind::EnvelopeCounts) };
    let skin = |index| FileError { index, ..skin_error(Kind::Limit, SectionKind::SkinCounts) };
    let less = |x: u32| x - 1;
    let file_bytes = less(exact.file_bytes);
    refused(Limits { file_bytes, ..exact }, whole(0), file_bytes);
    refused(Limits { parts: 4, ..exact }, whole(1), 4);
    refused(Limits { sections: 54, ..exact }, whole(2), 54);
    refused(Limits { vertices: 6, ..exact }, skin(0), 6);
    refused(Limits { joints: 3, ..exact }, envelope(1), 3);
    refused(Limits { proxies: 2, ..exact }, envelope(2), 2);
    refused(Limits { influences: 1, ..exact }, skin(1), 1);
    refused(Limits { shapes: 2, ..exact }, skin(4), 2);
    let bytes = Pieces::sample(Predictor::Kernel, STRETCHING).bytes();
    let exact = Limits { curves: 3, ..Limits::DEFAULT };
    assert!(Model::from_bytes_with(&bytes, &exact).is_ok());
    let found = Model::from_bytes_with(&bytes, &Limits { curves: 2, ..exact }).unwrap_err();
    assert_eq!(found, FileError { expected: 2, found: 3, ..envelope(7) });
    for at in [1, 2] {
        let section = SectionKind::EnvelopeCounts;
        let empty = FileError { index: at, expected: 1, ..envelope_error(Kind::Empty, section) };
        assert_eq!(edited(|b| b.set_word(section, at as usize, 0)), Err(empty));
    }
    let section = SectionKind::SkinCounts;
    let empty = FileError { index: 1, expected: 1, ..skin_error(Kind::Empty, section) };
    assert_eq!(edited(|b| b.set_word(section, 1, 0)), Err(empty));
    // A caller's limits cannot exceed the format's.
    let mut pieces = Pieces::small(Predictor::Rotational);
    pieces.set_word(SectionKind::EnvelopeCounts, 1, 65_536);
    let unlimited = Limits { joints: u32::MAX, ..Limits::DEFAULT };
    let found = Model::from_bytes_with(pieces.bytes(), &unlimited).unwrap_err();
    assert_eq!(found, FileError { expected: 65_535, found: 65_536, ..envelope(1) });
    // Without vertices, influences take no bytes.
    let mut pieces =
        Pieces::sample(Predictor::Rotational, Shape { vertices: 0, tangents: false, ..SMALL });
    let unlimited = Limits { influences: u32::MAX, ..Limits::DEFAULT };
    let beyond = FileError { expected: 65_535, found: 65_536, ..skin(1) };
    for (found, expected) in [(65_535, Ok(())), (65_536, Err(beyond))] {
        pieces.set_word(SectionKind::SkinCounts, 1, found);
        let loaded = Model::from_bytes_with(pieces.bytes(), &unlimited).map(|_| ());
        assert_eq!(loaded, expected);
    }
}

#[test]
fn as_many_parts_and_sections_load_as_the_limits_allow() {
    let Limits { parts, sections, .. } = Limits::DEFAULT;
    let with = |parts: usize, sections: usize| {
        let mut pieces = Pieces::loose(SMALL);
        let further = sections - pieces.sections.len();
        pieces.parts.resize(parts, PartRow { kind: 9, flags: 0 });
        pieces.sections.extend((0..further).map(|at| Content {
            bytes: Vec::new(),
            ..Content::unknown(at as u16, (at % (parts - 1)) as u16 + 1, 0)
        }));
        Model::from_bytes(pieces.bytes()).map(|_| ())
    };
    let (parts, sections) = (usize::from(parts), usize::from(sections));
    assert_eq!(with(parts, 40), Ok(()));
    let beyond = |index, most: usize| FileError {
        index,
        expected: most as u32,
        found: most as u32 + 1,
        ..file_error(Kind::Limit)
    };
    assert_eq!(with(parts + 1, 40), Err(beyond(1, parts)));
    // Each row is compared with every other row.
    if !cfg!(miri) {
        assert_eq!(with(parts, sections), Ok(()));
    }
    assert_eq!(with(parts, sections + 1), Err(beyond(2, sections)));
}
