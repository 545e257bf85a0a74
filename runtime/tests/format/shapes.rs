//! Refusals of a skin's shapes.

use crate::common::skin_error;
use models::{Pieces, SMALL, Shape, ShapeContent};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::{Element, MAGNITUDE_MAX, SectionKind};
use sinew_runtime::{FileError, FileErrorKind as Kind, Model};

/// Two blocks, the second of six vertices.
const VERTICES: usize = 70;

fn pieces(element: Element) -> Pieces {
    let mut pieces = Pieces::sample(Predictor::Rotational, Shape { vertices: VERTICES, ..SMALL });
    pieces.set_shapes(&ShapeContent::sample(element, 5, VERTICES));
    pieces
}

/// Loads a skin with changed shapes.
fn edited(element: Element, edit: impl FnOnce(&mut Pieces)) -> Result<(), FileError> {
    let mut pieces = pieces(element);
    edit(&mut pieces);
    Model::from_bytes(pieces.bytes()).map(|_| ())
}

fn word(kind: SectionKind, index: usize, value: u32) -> Result<(), FileError> {
    edited(Element::F32, |pieces| pieces.set_word(kind, index, value))
}

/// Entries of the sample: shapes 0, 2 and 3 in block 0, then 0, 2, 3 and 4 in block 1.
#[test]
fn entries_are_those_the_tests_assume() {
    let mut pieces = pieces(Element::F32);
    let words = |bytes: &[u8]| -> Vec<u32> {
        bytes.as_chunks().0.iter().map(|le| u32::from_le_bytes(*le)).collect()
    };
    assert_eq!(words(pieces.section(SectionKind::ShapeBlocks)), [0, 3, 7]);
    let entries = words(pieces.section(SectionKind::ShapeEntries));
    let shapes: Vec<u32> = entries.chunks(4).map(|entry| entry[2]).collect();
    assert_eq!(shapes, [0, 2, 3, 0, 2, 3, 4]);
    assert_eq!(entries[..4], [u32::MAX, u32::MAX, 0, 0]);
    assert_eq!(
        entries[12..16],
        [63, 0, 0, entries[11] + entries[8].count_ones() + entries[9].count_ones()]
    );
}

#[test]
fn the_sample_loads_whatever_its_numbers_are() {
    for element in [Element::F32, Element::F16, Element::I8] {
        assert_eq!(edited(element, |_| {}), Ok(()));
    }
}

#[test]
fn blocks_follow_each_other() {
    let error = |index| FileError { index, ..skin_error(Kind::Invalid, SectionKind::ShapeBlocks) };
    for (index, value) in [(0, 1), (1, 8), (2, 2), (2, u32::MAX)] {
        assert_eq!(word(SectionKind::ShapeBlocks, index, value), Err(error(index as u32)));
    }
    // Entries outside every block.
    let counts = skin_error(Kind::Mismatch, SectionKind::SkinCounts);
    let rest = FileError { index: 5, expected: 6, found: 7, ..counts };
    assert_eq!(word(SectionKind::ShapeBlocks, 2, 6), Err(rest));
    assert_eq!(rest.to_string(), "part 1: entries: the blocks need 6, found 7");
}

#[test]
fn entries_list_shapes_in_order_and_existing_vertices() {
    let section = SectionKind::ShapeEntries;
    let invalid = |index| FileError { index, ..skin_error(Kind::Invalid, section) };
    let index = FileError { index: 1, expected: 5, found: 5, ..skin_error(Kind::Index, section) };
    assert_eq!(word(section, 6, 5), Err(index));
    assert_eq!(word(section, 6, 0), Err(invalid(1)), "not above the one before it");
    let none = edited(Element::F32, |pieces| {
        pieces.section(section)[16..24].fill(0);
    });
    assert_eq!(none, Err(invalid(1)), "no vertex");
    // Vertex 70 does not exist.
    assert_eq!(word(section, 12, 127), Err(invalid(3)));
    assert_eq!(word(section, 13, 1 << 31), Err(invalid(3)));
    let start =
        FileError { index: 1, expected: 64, found: 65, ..skin_error(Kind::Mismatch, section) };
    assert_eq!(word(section, 7, 65), Err(start));
    assert_eq!(start.to_string(), "part 1: entry 1: expected at delta 64, found at 65");
}

#[test]
fn counts_are_those_of_the_entries() {
    let error = |index, expected| FileError {
        index,
        expected,
        found: expected + 1,
        ..skin_error(Kind::Mismatch, SectionKind::SkinCounts)
    };
    let deltas = |pieces: &mut Pieces| {
        let le = *pieces.word(SectionKind::SkinCounts, 6).unwrap();
        u32::from_le_bytes(le)
    };
    let own = deltas(&mut pieces(Element::I8));
    let more = edited(Element::I8, |pieces| {
        pieces.set_word(SectionKind::SkinCounts, 6, own + 1);
        pieces.section(SectionKind::ShapeDeltas).extend([0; 3]);
        pieces.section(SectionKind::ShapeSlopes).extend([0; 2]);
    });
    assert_eq!(more, Err(error(6, own)));
    let limit =
        |index| FileError { index, found: 1, ..skin_error(Kind::Limit, SectionKind::SkinCounts) };
    for index in [5, 6] {
        let mut plain = Pieces::small(Predictor::Rotational);
        plain.set_word(SectionKind::SkinCounts, index as usize, 1);
        assert_eq!(Model::from_bytes(plain.bytes()).map(|_| ()), Err(limit(index)), "no shapes");
    }
}

#[test]
fn numbers_are_finite_and_halves_not_subnormal() {
    for section in [SectionKind::ShapeDeltas, SectionKind::ShapeSlopes] {
        let error = |index| FileError { index, ..skin_error(Kind::Float, section) };
        for bad in [f32::NAN, f32::INFINITY, 2.0 * MAGNITUDE_MAX] {
            let found = edited(Element::F32, |pieces| pieces.set_float(section, 7, bad));
            assert_eq!(found, Err(error(7)));
        }
        for bad in [0x7c00, 0xfc00, 0x7e01, 1, 0x83ff] {
            let found = edited(Element::F16, |pieces| pieces.set_half(section, 9, bad));
            assert_eq!(found, Err(error(9)), "{bad:#x}");
        }
    }
    let step = FileError { index: 8, ..skin_error(Kind::Float, SectionKind::Shapes) };
    let found = edited(Element::I8, |pieces| pieces.set_float(SectionKind::Shapes, 8, f32::NAN));
    assert_eq!(found, Err(step));
    let errors = FileError { index: 1, ..skin_error(Kind::Float, SectionKind::ShapeErrors) };
    let found = edited(Element::I8, |pieces| pieces.set_float(SectionKind::ShapeErrors, 1, -1.0));
    assert_eq!(found, Err(errors));
}

#[test]
fn boxes_hold_every_delta_and_0() {
    let error =
        |index, found| FileError { index, found, ..skin_error(Kind::Invalid, SectionKind::Shapes) };
    // Shape 1 moves nothing; least x, greatest z.
    for (index, value) in [(10, 0.5), (15, -0.5)] {
        let found = edited(Element::F32, |p| p.set_float(SectionKind::Shapes, index, value));
        assert_eq!(found, Err(error(1, 0)));
    }
    for element in [Element::F32, Element::F16, Element::I8] {
        // The first delta belongs to the first shape.
        let content = ShapeContent::sample(element, 5, VERTICES);
        let [x, ..] = content.delta(0, 0);
        let place = if x < 0.0 { 2 } else { 5 };
        let within = edited(element, |p| p.set_float(SectionKind::Shapes, place, 0.5 * x));
        assert_eq!(within, Err(error(0, 0)), "{x}");
    }
    assert_eq!(
        error(0, 3).to_string(),
        "part 1: the box of shape 0 does not hold 0, or not delta 3"
    );
}

#[test]
fn deltas_and_slopes_are_of_one_element() {
    let set = |pieces: &mut Pieces, kind: SectionKind, element: u8| {
        let mut all = pieces.sections.iter_mut();
        all.find(|content| content.kind == kind.number()).unwrap().element = element;
    };
    let (f32, f16) = (Element::F32.number(), Element::F16.number());
    let other = edited(Element::F32, |pieces| set(pieces, SectionKind::ShapeSlopes, f16));
    let values = FileError {
        expected: f32.into(),
        found: f16.into(),
        ..skin_error(Kind::Mismatch, SectionKind::ShapeSlopes)
    };
    assert_eq!(other, Err(values));
    assert_eq!(
        values.to_string(),
        "part 1: section shape_slopes: expected the deltas' element type 1, found 4"
    );
    // Both have another element type, with another number of bytes.
    let both = edited(Element::F32, |pieces| {
        set(pieces, SectionKind::ShapeDeltas, f16);
        set(pieces, SectionKind::ShapeSlopes, f16);
    });
    assert_eq!(both.unwrap_err().kind, Kind::Length);
    for unknown in [Element::U32.number(), Element::Mixed.number(), 200] {
        let found = edited(Element::F32, |p| set(p, SectionKind::ShapeDeltas, unknown));
        let FileError { kind, found, .. } = found.unwrap_err();
        assert_eq!((kind, found), (Kind::Unsupported, unknown.into()));
    }
}

#[test]
fn a_skin_with_shapes_has_all_of_their_sections() {
    for kind in [
        SectionKind::Shapes,
        SectionKind::ShapeBlocks,
        SectionKind::ShapeEntries,
        SectionKind::ShapeDeltas,
        SectionKind::ShapeSlopes,
    ] {
        let without = edited(Element::F16, |pieces| {
            pieces.sections.retain(|content| content.kind != kind.number());
        });
        assert_eq!(without, Err(skin_error(Kind::Missing, kind)));
        let longer = edited(Element::F16, |pieces| pieces.section(kind).push(0));
        assert_eq!(longer.unwrap_err().kind, Kind::Length);
    }
    let without = edited(Element::F16, |pieces| {
        pieces.sections.retain(|content| content.kind != SectionKind::ShapeErrors.number());
    });
    assert_eq!(without, Ok(()));
}
