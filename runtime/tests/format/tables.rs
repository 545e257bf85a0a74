//! The tables of parts and of sections, row by row.

use crate::common::file_error;
use crate::format::{edited, error};
use models::{Content, JOINTLESS, Pieces, SMALL, STRETCHING};
use sinew_runtime::envelope::{ENVELOPE_SECTIONS, EnvelopeCounts, HelperKind, Predictor};
use sinew_runtime::format::{Element, PartKind, PartRow, SectionKind, SectionRow};
use sinew_runtime::skin::{SKIN_SECTIONS, SkinCounts};
use sinew_runtime::{Envelope, FileError, FileErrorKind as Kind, Model, Skin};

#[test]
fn each_row_of_the_part_table_is_checked() {
    let rows = |found| FileError { index: 1, expected: 4, found, ..file_error(Kind::Malformed) };
    assert_eq!(edited(|b| b.parts.clear()), Err(rows(0)));
    let unknown = |kind, flags| PartRow { kind, flags };
    let third = FileError { part: Some(2), ..file_error(Kind::Unsupported) };
    for kind in [0, 9, 255, 65_535] {
        let refused = FileError { found: kind.into(), ..third };
        assert_eq!(edited(|b| b.parts.push(unknown(kind, 1))), Err(refused));
        assert_eq!(edited(|b| b.parts.push(unknown(kind, 0))), Ok(()));
    }
    for flags in [2, 3, 0x8000] {
        let refused = FileError { part: Some(0), found: flags.into(), ..third };
        assert_eq!(edited(|b| b.parts[0].flags = flags), Err(refused));
        let refused = FileError { found: flags.into(), ..third };
        assert_eq!(edited(|b| b.parts.push(unknown(9, flags))), Err(refused));
    }
    // This reader knows the kind, so the flag has no effect.
    assert_eq!(edited(|b| b.parts[1].flags = 0), Ok(()));
    let pieces = Pieces::small(Predictor::Rotational);
    let odd = pieces.bytes_with(|file| {
        file.parts.remove(0);
        file.padding.push(0);
    });
    assert_eq!(error(&odd), rows(7));
    assert_eq!(PartKind::ALL.map(PartKind::number), [1, 2, 3, 4, 5, 6, 7]);
}

#[test]
fn each_row_of_the_section_table_is_checked() {
    let extra = Content::unknown;
    let unknown = |part, found| {
        Err(FileError { part: Some(part), index: 21, found, ..file_error(Kind::Unsupported) })
    };
    for part in [0, 1] {
        assert_eq!(edited(|b| b.sections.push(extra(999, part, 0))), Ok(()));
        assert_eq!(edited(|b| b.sections.push(extra(999, part, 1))), unknown(part, 999));
        assert_eq!(edited(|b| b.sections.push(extra(999, part, 2))), unknown(part, 2));
        let reserved = Content { reserved: 7, ..extra(999, part, 0) };
        assert_eq!(edited(|b| b.sections.push(reserved)), unknown(part, 7));
        // The element type of a skipped section does not matter.
        let element = Content { element: 200, ..extra(999, part, 0) };
        assert_eq!(edited(|b| b.sections.push(element)), Ok(()));
    }
    let skipped = PartRow { kind: 9, flags: 0 };
    let further = |content| {
        edited(|b| {
            b.parts.push(skipped);
            b.sections.push(content);
        })
    };
    assert_eq!(further(extra(999, 2, 1)), Ok(()), "sections of a skipped part are skipped");
    let element = Content { element: 200, ..Content::new(SectionKind::Keys, 2, vec![1; 5]) };
    assert_eq!(further(element), Ok(()), "whatever they say that they are");
    assert_eq!(further(extra(999, 2, 3)), unknown(2, 3), "but for their flags");
    let nowhere = FileError { index: 21, expected: 2, found: 2, ..file_error(Kind::PartIndex) };
    assert_eq!(edited(|b| b.sections.push(extra(999, 2, 0))), Err(nowhere));
    // Of a row in the file's own order: its part and its kind.
    let own = Pieces::small(Predictor::Rotational);
    let own =
        |row: usize| (own.sections[row].part, SectionKind::from_number(own.sections[row].kind));
    let at = |kind, index: u32, (part, section), expected, found| {
        let part = Some(part);
        Err(FileError { part, section, index, expected, found, ..file_error(kind) })
    };
    let again = Content::new(SectionKind::RestNormals, 1, vec![0; 96]);
    assert_eq!(
        edited(|b| b.sections.push(again)),
        at(Kind::Duplicate, 21, (1, Some(SectionKind::RestNormals)), 0, 0)
    );
    let twice = |part| edited(|b| b.sections.extend([extra(999, 0, 0), extra(999, part, 0)]));
    assert_eq!(twice(0), at(Kind::Duplicate, 22, (0, None), 0, 0));
    assert_eq!(twice(1), Ok(()), "a kind of another part");
    let rows = |edit: fn(&mut [SectionRow])| {
        let file = Pieces::small(Predictor::Rotational).bytes_with_rows(edit);
        Model::from_bytes(file).map(|_| ())
    };
    let pieces = Pieces::small(Predictor::Rotational).bytes();
    let model = Model::from_bytes(&pieces).unwrap();
    let sound: Vec<SectionRow> = model.sections().map(|section| section.row).collect();
    let end = |row: usize| sound[row].offset + sound[row].bytes;
    let blob = model.blob().len() as u32;
    let third = sound[3].offset;
    assert_eq!(rows(|r| r[3].offset += 4), at(Kind::Alignment, 3, own(3), 16, third + 4));
    assert_eq!(rows(|r| r[3].offset = 0), at(Kind::Overlap, 3, own(3), end(2), 0));
    let longer = at(Kind::Overlap, 4, own(4), end(3) + 64, sound[4].offset);
    assert_eq!(rows(|r| r[3].bytes += 64), longer);
    let beyond = |found| at(Kind::Bounds, 20, own(20), blob, found);
    assert_eq!(rows(|r| r[20].offset += 1 << 20), beyond(end(20) + (1 << 20)));
    assert_eq!(rows(|r| r[20].bytes = u32::MAX), beyond(u32::MAX));
    assert_eq!(rows(|r| r[20].offset = 0xffff_fff0), beyond(0xffff_fff0 + sound[20].bytes));
    assert_eq!(rows(|r| r.swap(3, 4)), at(Kind::Overlap, 4, own(3), end(4), third));
    let pieces = Pieces::small(Predictor::Rotational);
    let odd = pieces.bytes_with(|file| {
        file.sections.remove(0);
        file.padding.push(0);
    });
    let found = 16 * sound.len() as u32 - 1;
    let values = FileError { index: 2, expected: 16, found, ..file_error(Kind::Malformed) };
    assert_eq!(error(&odd), values);
}

#[test]
fn each_section_has_the_type_of_its_kind() {
    for (row, content) in Pieces::small(Predictor::Rotational).sections.iter().enumerate() {
        let known = Element::ALL.map(Element::number);
        for element in known.into_iter().chain([5, 255]).filter(|e| *e != content.element) {
            let refused = FileError {
                part: Some(content.part),
                index: row as u32,
                found: element.into(),
                ..file_error(Kind::Unsupported)
            };
            assert_eq!(edited(|b| b.sections[row].element = element), Err(refused));
        }
    }
}

#[test]
fn each_section_is_required_and_has_its_length() {
    let samples = Predictor::ALL.map(|each| [SMALL, STRETCHING].map(|s| Pieces::sample(each, s)));
    let jointless = Pieces::sample(Predictor::Kernel, JOINTLESS);
    for sample in samples.iter().flatten().chain([&jointless]) {
        for (part, section) in [0, 1].into_iter().flat_map(|p| SectionKind::ALL.map(|s| (p, s))) {
            section_of(sample, part, section);
        }
    }
    let huge = EnvelopeCounts {
        predictor: Predictor::Kernel,
        joint_len: u32::MAX,
        proxy_len: u32::MAX,
        root: 0,
        group_len: u32::MAX,
        correction_len: u32::MAX,
        stretches: true,
        curve_len: 0,
        helper_kind: HelperKind::Affine,
    };
    assert_eq!(huge.section_bytes(SectionKind::C2), None);
    assert_eq!(huge.section_bytes(SectionKind::Names), Some(1 << 34));
    let huge = SkinCounts {
        vertex_len: u32::MAX,
        influence_len: u32::MAX,
        envelope: 0,
        range_len: u32::MAX,
        shape_len: u32::MAX,
        entry_len: 0,
        delta_len: u32::MAX,
    };
    assert_eq!(huge.section_bytes(SectionKind::InfluenceWeights, 1, Element::F32), None);
    assert_eq!(huge.section_bytes(SectionKind::Names, 1, Element::F32), Some(1 << 34));
}

fn section_of(sample: &Pieces, part: u16, section: SectionKind) {
    let edited = |edit: &dyn Fn(&mut Pieces)| {
        let mut pieces = sample.clone();
        edit(&mut pieces);
        Model::from_bytes(pieces.bytes()).map(|_| ())
    };
    let error = |kind| FileError { part: Some(part), section: Some(section), ..file_error(kind) };
    let model = Model::from_bytes(sample.bytes()).unwrap();
    let (envelope, skin) =
        (model.first::<Envelope>().unwrap().counts(), model.first::<Skin>().unwrap().counts());
    let (own, has) = match part {
        0 => (ENVELOPE_SECTIONS.as_slice(), Some(envelope.has(section))),
        _ => (SKIN_SECTIONS.as_slice(), skin.has(section)),
    };
    let own = own.contains(&section);
    if !own || has == Some(false) {
        // A section of another kind of part is ignored, unless it is required.
        let row = sample.sections.len() as u32;
        let unknown = FileError {
            part: Some(part),
            index: row,
            found: section.number().into(),
            ..file_error(Kind::Unsupported)
        };
        for flags in [0, 1] {
            let extra = Content { flags, ..Content::new(section, part, vec![0xff; 4]) };
            let found = edited(&|b| b.sections.push(extra.clone()));
            let expected = match (own, flags) {
                (true, _) => Err(error(Kind::Unexpected)),
                (false, 0) => Ok(()),
                (false, _) => Err(unknown),
            };
            assert_eq!(found, expected, "{envelope:?} {section:?}");
        }
        return;
    }
    let is_it = |content: &Content| (content.part, content.kind) == (part, section.number());
    let without = edited(&|b| b.sections.retain(|content| !is_it(content)));
    assert_eq!(without, if has.is_none() { Ok(()) } else { Err(error(Kind::Missing)) });
    let found = sample.clone().section_of(part, section).len();
    for change in [-1, 1].into_iter().filter(|change| *change > 0 || found > 0) {
        let refused = edited(&|b| {
            let content = b.section_of(part, section);
            content.resize(content.len().wrapping_add_signed(change), 0);
        });
        if section == SectionKind::Names {
            // The last name must end with the text.
            let of_envelope = envelope.joint_len + envelope.curve_len;
            let last = if part == 0 { of_envelope } else { skin.range_len };
            let expected = FileError { index: last, ..error(Kind::Invalid) };
            assert_eq!(refused, Err(expected));
            continue;
        }
        let stated = match (part, section) {
            (_, SectionKind::Corrections) => Some(found as u64),
            (0, _) => envelope.section_bytes(section),
            _ => skin.section_bytes(section, envelope.palette_len(), Element::F32),
        };
        let (expected, found) = (stated.unwrap() as u32, found.wrapping_add_signed(change) as u32);
        assert_eq!(refused, Err(FileError { expected, found, ..error(Kind::Length) }));
    }
}
