//! Files that must load and files that must not.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{
    Builder, Content, Rng, SMALL, Shape, apart, envelope_error, exercise, file_error, floats, seal,
    skin_error, skinned, words,
};
use sinew_runtime::envelope::{ENVELOPE_SECTIONS, EnvelopeCounts, Predictor};
use sinew_runtime::format::{
    Axis, CHECKSUM_OFFSET, Element, Handedness, MAGIC, PartKind, PartRow, SectionKind, Space,
};
use sinew_runtime::skin::{LENGTH_TOLERANCE, NO_ENVELOPE, SKIN_SECTIONS, SkinCounts};
use sinew_runtime::{FileError, FileErrorKind as Kind, Limits, Model};

fn error(bytes: &[u8]) -> FileError {
    Model::from_bytes(bytes).unwrap_err()
}

/// Loads a sample that `edit` has changed.
fn edited(edit: impl FnOnce(&mut Builder)) -> Result<(), FileError> {
    let mut builder = Builder::small(Predictor::Rotational);
    edit(&mut builder);
    Model::from_bytes(builder.bytes()).map(|_| ())
}

#[test]
fn a_sound_file_loads_at_any_address() {
    // Further rows shift the blob's start through many residues.
    for further in (0..=19).step_by(apart(19)) {
        let mut builder = Builder::small(Predictor::Rotational);
        builder.sections.extend((900..900 + further).map(|kind| Content::unknown(kind, 0, 0)));
        let bytes = builder.bytes();
        exercise(&bytes).unwrap();
        for shift in 1..4 {
            let shifted = [&[0; 3][..shift], bytes.as_slice()].concat();
            exercise(&shifted[shift..]).unwrap();
        }
    }
}

#[test]
fn accessors_give_what_was_written() {
    fn shared<T: Send + Sync + Copy>(value: T) -> T {
        value
    }
    let mut builder = Builder::small(Predictor::Rotational);
    builder.set_float(SectionKind::C1, 8 * 4 + 5, 0.625);
    // Block 1, column 2, row 3 of it.
    builder.set_float(SectionKind::C2, 8 * (16 + 2) + 3, 0.375);
    let bytes = builder.bytes();
    let model = shared(Model::from_bytes(bytes.as_slice()).unwrap());
    let envelope = shared(model.envelope().unwrap());
    assert_eq!((envelope.name(), envelope.root()), ("arm", 1));
    assert_eq!(envelope.joint_name(3), Some("joint 3"));
    assert_eq!(envelope.joint_name(4), None);
    assert_eq!([0, 1, 2, 3].map(|j| envelope.parent(j)), [Some(2), None, Some(1), Some(0)]);
    assert_eq!(envelope.evaluation_order().collect::<Vec<_>>(), [1, 2, 0, 3]);
    assert_eq!(envelope.inverse_bind(0).unwrap()[0][3], -2.0);
    assert_eq!(envelope.pose_range(0), Some(1.5));
    assert_eq!(envelope.c1(5, 4), Some(0.625));
    assert_eq!(envelope.c2(11, 2), Some(0.375));
    assert_eq!((envelope.c1(12, 0), envelope.c1(0, 9), envelope.c2(0, 16)), (None, None, None));
    let (first, second) = (envelope.key(0).unwrap(), envelope.key(1).unwrap());
    assert_eq!((first.joint, first.residual), (2, None));
    assert_eq!((second.joint, second.residual.unwrap().0), (3, 1));
    assert_eq!((first.twist[0][0], first.shear[0][0], first.shear[3][0]), (0.5, 0.5, 0.5));
    assert_eq!(envelope.certificate().lbs_training_rms, 0.04);
    let skin = shared(model.skin().unwrap());
    assert_eq!((skin.name(), skin.vertex_len(), skin.influence_len()), ("sleeve", 7, 2));
    assert_eq!((skin.palette_len(), skin.envelope_part()), (3, Some(0)));
    assert_eq!(skin.influences(1).collect::<Vec<_>>(), [(1, 0.75), (2, 0.25)]);
    assert_eq!(skin.influences(usize::MAX).len(), 0);
    let written = builder.section(SectionKind::RestNormals);
    assert_eq!(floats(&skin.rest_normal(6).unwrap()), written[72..]);
    assert_eq!(
        (skin.rest_position(7), skin.rest_normal(7), skin.rest_tangent(7)),
        Default::default()
    );
    assert_eq!((skin.rest_box(3), skin.rest_box(usize::MAX)), (None, None));
    assert!(skin.rest_box(1).unwrap().contains(skin.rest_position(0).unwrap()));
    let ranges = skin.ranges().collect::<Vec<_>>();
    assert_eq!(ranges, [("upper", 0..3), ("lower", 4..7)]);
    assert!(model.envelope_named("arm").is_some() && model.envelope_named("sleeve").is_none());
    assert!(model.skin_named("sleeve").is_some() && model.skin_named("arm").is_none());
    assert_eq!((model.parts().len(), model.sections().len()), (2, 18));
    assert_eq!((model.as_bytes(), model.space()), (bytes.as_slice(), Space::default()));
    let first = model.sections().next().unwrap();
    assert_eq!(model.blob()[..24], *first.bytes);
    assert_eq!(model.into_bytes(), bytes);
}

#[test]
fn several_envelopes_and_skins_stand_in_one_file() {
    let bytes = Builder::several().bytes();
    exercise(&bytes).unwrap();
    let model = Model::from_bytes(bytes).unwrap();
    let kinds = model.parts().map(|row| row.kind).collect::<Vec<_>>();
    assert_eq!(kinds, [1, 2, 1, 2, 2]);
    let predictors = model.envelopes().map(|envelope| (envelope.part(), envelope.predictor()));
    let expected = [(0, Predictor::Rotational), (2, Predictor::Kernel)];
    assert_eq!(predictors.collect::<Vec<_>>(), expected);
    let skins = model.skins().map(|skin| (skin.part(), skin.envelope_part(), skin.palette_len()));
    let expected = [(1, Some(0), 3), (3, Some(2), 7), (4, None, 0)];
    assert_eq!(skins.collect::<Vec<_>>(), expected);
    let followed = model.skins().map(|skin| model.envelope_of(&skin).map(|found| found.part()));
    assert_eq!(followed.collect::<Vec<_>>(), [Some(0), Some(2), None]);
    assert_eq!((model.envelope().unwrap().part(), model.skin().unwrap().part()), (0, 1));
    let eye = model.skin_named("eye").unwrap();
    assert_eq!((eye.part(), eye.influence_len(), eye.influences(0).len()), (4, 0, 0));
    // A mesh alone, and an envelope alone.
    let loose = Model::from_bytes(Builder::loose(SMALL).bytes()).unwrap();
    assert!(loose.envelope().is_none() && loose.skin().is_some());
    let mut alone = Builder::small(Predictor::Hybrid);
    alone.parts.truncate(1);
    alone.sections.retain(|content| content.part == 0);
    let alone = Model::from_bytes(alone.bytes()).unwrap();
    assert!(alone.envelope().is_some() && alone.skin().is_none());
}

#[test]
fn sections_stand_in_any_order() {
    let builder = Builder::several();
    let expected = Model::from_bytes(builder.bytes()).unwrap();
    for first in [0, 7, 20] {
        let mut turned = builder.clone();
        turned.sections.rotate_left(first);
        turned.sections.reverse();
        let bytes = turned.bytes();
        exercise(&bytes).unwrap();
        let model = Model::from_bytes(bytes).unwrap();
        let envelopes = |model: &Model<Vec<u8>>| {
            model.envelopes().map(|envelope| envelope.counts()).collect::<Vec<_>>()
        };
        assert_eq!(envelopes(&model), envelopes(&expected));
        for (found, expected) in model.skins().zip(expected.skins()) {
            let palette = vec![common::IDENTITY; found.palette_len()];
            assert_eq!(skinned(found, &palette), skinned(expected, &palette));
        }
    }
}

#[test]
fn every_truncation_is_refused() {
    let bytes = Builder::small(Predictor::Rotational).bytes();
    for len in (0..bytes.len()).step_by(apart(199)) {
        assert_eq!(error(&bytes[..len]), file_error(Kind::Malformed), "{len}");
        let mut sealed = bytes[..len].to_vec();
        seal(&mut sealed);
        assert!(exercise(&sealed).is_none(), "{len}");
    }
}

#[test]
fn extra_bytes_are_refused() {
    let mut bytes = Builder::small(Predictor::Rotational).bytes();
    bytes.push(0);
    seal(&mut bytes);
    assert_eq!(error(&bytes), file_error(Kind::Malformed));
}

#[test]
fn every_flipped_bit_is_refused_and_harmless_when_sealed() {
    let shape = Shape { vertices: 2, joints: 3, proxies: 2, influences: 2, tangents: true };
    let bytes = Builder::sample(shape).bytes();
    let mut loaded = 0;
    for bit in (0..8 * bytes.len()).step_by(apart(499)) {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(Model::from_bytes(&flipped).is_err(), "{bit}");
        seal(&mut flipped);
        loaded += usize::from(exercise(&flipped).is_some());
    }
    // Low bits of floats, mostly: the second half of the test has evaluated something.
    assert!(loaded > bytes.len() / apart(499), "{loaded}");
}

#[test]
fn random_damage_is_harmless() {
    let mut rng = Rng(99);
    let mut below = |n: usize| (rng.next() % n as u64) as usize;
    let bytes = Builder::small(Predictor::Rotational).bytes();
    for _ in (0..20_000).step_by(apart(1999)) {
        let mut damaged = bytes.clone();
        // Half of the damage goes to the head and the tables, where it says most.
        for _ in 0..1 + below(4) {
            let span = if below(2) == 0 { 320 } else { bytes.len() };
            let at = below(span);
            damaged[at] = [0, 1, 0x7f, 0x80, 0xff, below(256) as u8][below(6)];
        }
        if below(8) == 0 {
            damaged.truncate(below(bytes.len()));
        }
        seal(&mut damaged);
        exercise(&damaged);
    }
}

#[test]
fn each_field_of_the_head_is_checked() {
    let word = u32::from_le_bytes;
    let found = *b"SNEX";
    let refused =
        FileError { expected: word(MAGIC), found: word(found), ..file_error(Kind::NotAModel) };
    assert_eq!(edited(|b| b.magic = found), Err(refused));
    for version in [0, 1, 2, 4] {
        let refused = FileError { expected: 3, found: version.into(), ..file_error(Kind::Version) };
        assert_eq!(edited(|b| b.version = version), Err(refused));
    }
    let refused = FileError { found: 0x8000_0001, ..file_error(Kind::Unsupported) };
    assert_eq!(edited(|b| b.features = 0x8000_0001), Err(refused));
    let builder = Builder::small(Predictor::Rotational);
    let sum = |bytes: &[u8]| u32::from_le_bytes(*bytes[CHECKSUM_OFFSET..].first_chunk().unwrap());
    let mut bytes = builder.bytes();
    let expected = sum(&bytes) ^ 1;
    bytes[CHECKSUM_OFFSET] ^= 1;
    let refused = FileError { expected, found: expected ^ 1, ..file_error(Kind::Checksum) };
    assert_eq!(error(&bytes), refused);

    static LONG: [u8; 400] = [0; 400];
    let longer =
        |by: usize| builder.bytes_with(|file| file.padding = &LONG[..file.padding.len() + by]);
    assert_eq!(error(&longer(1)), file_error(Kind::Malformed), "a blob off its alignment");
    exercise(&longer(16)).unwrap();
    static ONES: [u8; 400] = [1; 400];
    let padded = builder.bytes_with(|file| file.padding = &ONES[..file.padding.len() + 16]);
    assert_eq!(error(&padded), file_error(Kind::Malformed));
    assert_eq!(error(b""), file_error(Kind::Malformed));
    assert_eq!(error(&MAGIC), file_error(Kind::Malformed));
}

#[test]
fn each_byte_of_the_space_is_checked() {
    let load = |space: [u8; 8]| {
        let builder = Builder { space, ..Builder::small(Predictor::Rotational) };
        Model::from_bytes(builder.bytes()).map(|model| model.space())
    };
    let none = || std::iter::once(None);
    let axes = || none().chain(Axis::ALL.map(Some));
    for (up, forward) in axes().flat_map(|up| axes().map(move |forward| (up, forward))) {
        for handedness in [Handedness::Right, Handedness::Left] {
            for unit in [None, Some(0.01), Some(1e-9), Some(1e9)] {
                let space = Space { up, forward, handedness, unit };
                let along = up.zip(forward).is_some_and(|(up, forward)| up.is_along(forward));
                let wrong = FileError { index: 1, ..file_error(Kind::Malformed) };
                let expected = if along { Err(wrong) } else { Ok(space) };
                assert_eq!(load(space.to_bytes()), expected);
            }
        }
    }
    let sound = Space { up: Some(Axis::Y), forward: Some(Axis::Z), ..Space::default() }.to_bytes();
    assert_eq!(sound, [3, 5, 1, 0, 0, 0, 0, 0]);
    let wrong = |index| Err(FileError { index, ..file_error(Kind::Malformed) });
    for (at, value) in [(0, 7), (0, 255), (1, 7), (1, 4), (2, 0), (2, 3), (3, 1), (3, 255)] {
        let mut space = sound;
        space[at] = value;
        assert_eq!(load(space), wrong(at as u32), "{at} {value}");
    }
    for unit in [f32::NAN, f32::INFINITY, -1.0, -0.0, 9e-10, 1.1e9, 1e-45] {
        let mut space = sound;
        space[4..].copy_from_slice(&unit.to_le_bytes());
        assert_eq!(load(space), wrong(4), "{unit}");
    }
}

#[test]
fn each_row_of_the_part_table_is_checked() {
    assert_eq!(edited(|b| b.parts.clear()), Err(file_error(Kind::Malformed)));
    let unknown = |kind, flags| PartRow { kind, flags };
    let third = FileError { part: Some(2), ..file_error(Kind::Unsupported) };
    for kind in [0, 3, 4, 255, 65_535] {
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
    // A reader knows this kind, so that the flag says nothing.
    assert_eq!(edited(|b| b.parts[1].flags = 0), Ok(()));
    let builder = Builder::small(Predictor::Rotational);
    let odd = builder.bytes_with(|file| {
        file.parts = &file.parts[1..];
        file.padding = &[0; 40][..file.padding.len() + 1];
    });
    assert_eq!(error(&odd), file_error(Kind::Malformed));
    assert_eq!(PartKind::ALL.map(PartKind::number), [1, 2]);
}

#[test]
fn each_row_of_the_section_table_is_checked() {
    let extra = Content::unknown;
    let unknown = |part, found| {
        Err(FileError { part: Some(part), index: 18, found, ..file_error(Kind::Unsupported) })
    };
    for part in [0, 1] {
        assert_eq!(edited(|b| b.sections.push(extra(999, part, 0))), Ok(()));
        assert_eq!(edited(|b| b.sections.push(extra(999, part, 1))), unknown(part, 999));
        assert_eq!(edited(|b| b.sections.push(extra(999, part, 2))), unknown(part, 2));
        let reserved = Content { reserved: 7, ..extra(999, part, 0) };
        assert_eq!(edited(|b| b.sections.push(reserved)), unknown(part, 7));
        // The type of what is skipped is nobody's affair.
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
    let nowhere = FileError { index: 18, expected: 2, found: 2, ..file_error(Kind::PartIndex) };
    assert_eq!(edited(|b| b.sections.push(extra(999, 2, 0))), Err(nowhere));
    let at = |kind, index| Err(FileError { index, ..file_error(kind) });
    let again = Content::new(SectionKind::RestNormals, 1, vec![0; 84]);
    assert_eq!(edited(|b| b.sections.push(again)), at(Kind::Duplicate, 18));
    let twice = |part| edited(|b| b.sections.extend([extra(999, 0, 0), extra(999, part, 0)]));
    assert_eq!(twice(0), at(Kind::Duplicate, 19));
    assert_eq!(twice(1), Ok(()), "a kind of another part");
    let rows = |edit| edited(|b| b.edit_rows = edit);
    assert_eq!(rows(|r| r[3].offset += 4), at(Kind::Alignment, 3));
    assert_eq!(rows(|r| r[3].offset = 0), at(Kind::Overlap, 3));
    assert_eq!(rows(|r| r[3].bytes += 64), at(Kind::Overlap, 4));
    assert_eq!(rows(|r| r[17].offset += 1 << 20), at(Kind::Bounds, 17));
    assert_eq!(rows(|r| r[17].bytes = u32::MAX), at(Kind::Bounds, 17));
    assert_eq!(rows(|r| r[17].offset = 0xffff_fff0), at(Kind::Bounds, 17));
    assert_eq!(rows(|r| r.swap(3, 4)), at(Kind::Overlap, 4));
    let builder = Builder::small(Predictor::Rotational);
    let odd = builder.bytes_with(|file| {
        file.sections = &file.sections[1..];
        file.padding = &[0; 40][..file.padding.len() + 1];
    });
    assert_eq!(error(&odd), file_error(Kind::Malformed));
}

#[test]
fn each_section_has_the_type_of_its_kind() {
    for (row, content) in Builder::small(Predictor::Rotational).sections.iter().enumerate() {
        let known = Element::ALL.map(Element::number);
        for element in known.into_iter().chain([4, 255]).filter(|e| *e != content.element) {
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
    for predictor in Predictor::ALL {
        for (part, section) in [0, 1].into_iter().flat_map(|p| SectionKind::ALL.map(|s| (p, s))) {
            section_of(predictor, part, section);
        }
    }
    let huge = EnvelopeCounts {
        predictor: Predictor::Hybrid,
        joint_len: u32::MAX,
        proxy_len: u32::MAX,
        root: 0,
        group_len: u32::MAX,
        correction_len: u32::MAX,
    };
    assert_eq!(huge.section_bytes(SectionKind::C2), None);
    assert_eq!(huge.section_bytes(SectionKind::Names), Some(1 << 34));
    let huge = SkinCounts {
        vertex_len: u32::MAX,
        influence_len: u32::MAX,
        envelope: 0,
        range_len: u32::MAX,
    };
    assert_eq!(huge.section_bytes(SectionKind::InfluenceWeights, 1), None);
    assert_eq!(huge.section_bytes(SectionKind::Names, 1), Some(1 << 34));
}

fn section_of(predictor: Predictor, part: u16, section: SectionKind) {
    let edited = |edit: &dyn Fn(&mut Builder)| {
        let mut builder = Builder::small(predictor);
        edit(&mut builder);
        Model::from_bytes(builder.bytes()).map(|_| ())
    };
    let error = |kind| FileError { part: Some(part), section: Some(section), ..file_error(kind) };
    let model = Model::from_bytes(Builder::small(predictor).bytes()).unwrap();
    let (envelope, skin) = (model.envelope().unwrap().counts(), model.skin().unwrap().counts());
    let (own, has) = match part {
        0 => (ENVELOPE_SECTIONS.as_slice(), Some(envelope.has(section))),
        _ => (SKIN_SECTIONS.as_slice(), skin.has(section)),
    };
    let own = own.contains(&section);
    if !own || has == Some(false) {
        // One of another kind of part is left alone, unless a reader must know it.
        let row = Builder::small(predictor).sections.len() as u32;
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
            assert_eq!(found, expected, "{predictor:?} {section:?}");
        }
        return;
    }
    let is_it = |content: &Content| (content.part, content.kind) == (part, section.number());
    let without = edited(&|b| b.sections.retain(|content| !is_it(content)));
    assert_eq!(without, if has.is_none() { Ok(()) } else { Err(error(Kind::Missing)) });
    for change in [-1, 1] {
        let refused = edited(&|b| {
            let content = b.section_of(part, section);
            content.resize(content.len().wrapping_add_signed(change), 0);
        });
        if section == SectionKind::Names {
            // The last name is to end with the text.
            let last = if part == 0 { envelope.joint_len } else { skin.range_len };
            let expected = FileError { index: last, ..error(Kind::Invalid) };
            assert_eq!(refused, Err(expected));
            continue;
        }
        let found = Builder::small(predictor).section_of(part, section).len();
        let stated = match (part, section) {
            (_, SectionKind::Corrections) => Some(found as u64),
            (0, _) => envelope.section_bytes(section),
            _ => skin.section_bytes(section, envelope.palette_len()),
        };
        let (expected, found) = (stated.unwrap() as u32, found.wrapping_add_signed(change) as u32);
        assert_eq!(refused, Err(FileError { expected, found, ..error(Kind::Length) }));
    }
}

#[test]
fn limits_are_honoured() {
    let bytes = Builder::several().bytes();
    let exact = Limits {
        file_bytes: bytes.len() as u32,
        parts: 5,
        sections: 9 + 9 + 9 + 9 + 6,
        vertices: SMALL.vertices as u32,
        joints: SMALL.joints as u32,
        proxies: SMALL.proxies as u32,
        influences: SMALL.influences as u32,
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
    refused(Limits { sections: 41, ..exact }, whole(2), 41);
    refused(Limits { vertices: 6, ..exact }, skin(0), 6);
    refused(Limits { joints: 3, ..exact }, envelope(1), 3);
    refused(Limits { proxies: 2, ..exact }, envelope(2), 2);
    refused(Limits { influences: 1, ..exact }, skin(1), 1);
    for at in [1, 2] {
        let section = SectionKind::EnvelopeCounts;
        let empty = FileError { index: at, expected: 1, ..envelope_error(Kind::Empty, section) };
        assert_eq!(edited(|b| b.set_word(section, at as usize, 0)), Err(empty));
    }
    let section = SectionKind::SkinCounts;
    let empty = FileError { index: 1, expected: 1, ..skin_error(Kind::Empty, section) };
    assert_eq!(edited(|b| b.set_word(section, 1, 0)), Err(empty));
    // Limits do not lift what the format cannot hold.
    let mut builder = Builder::small(Predictor::Rotational);
    builder.set_word(SectionKind::EnvelopeCounts, 1, 65_536);
    let unlimited = Limits { joints: u32::MAX, ..Limits::DEFAULT };
    let found = Model::from_bytes_with(builder.bytes(), &unlimited).unwrap_err();
    assert_eq!(found, FileError { expected: 65_535, found: 65_536, ..envelope(1) });
    // Without vertices, influences cost no bytes.
    let mut builder = Builder::sample(Shape { vertices: 0, tangents: false, ..SMALL });
    let unlimited = Limits { influences: u32::MAX, ..Limits::DEFAULT };
    let beyond = FileError { expected: 65_535, found: 65_536, ..skin(1) };
    for (found, expected) in [(65_535, Ok(())), (65_536, Err(beyond))] {
        builder.set_word(SectionKind::SkinCounts, 1, found);
        let loaded = Model::from_bytes_with(builder.bytes(), &unlimited).map(|_| ());
        assert_eq!(loaded, expected);
    }
}

#[test]
fn as_many_parts_and_sections_load_as_the_limits_allow() {
    let Limits { parts, sections, .. } = Limits::DEFAULT;
    let with = |parts: usize, sections: usize| {
        let mut builder = Builder::loose(SMALL);
        let further = sections - builder.sections.len();
        builder.parts.resize(parts, PartRow { kind: 9, flags: 0 });
        builder.sections.extend((0..further).map(|at| Content {
            bytes: Vec::new(),
            ..Content::unknown(at as u16, (at % (parts - 1)) as u16 + 1, 0)
        }));
        Model::from_bytes(builder.bytes()).map(|_| ())
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
    // Each row is compared with every other.
    if !cfg!(miri) {
        assert_eq!(with(parts, sections), Ok(()));
    }
    assert_eq!(with(parts, sections + 1), Err(beyond(2, sections)));
}

#[test]
fn each_float_is_checked() {
    let envelope = [
        (SectionKind::Certificate, 0),
        (SectionKind::InverseBinds, 0),
        (SectionKind::Keys, 1),
        (SectionKind::C1, 0),
        (SectionKind::C2, 0),
        (SectionKind::PoseRanges, 0),
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
    for index in 0..5 {
        let refused = edited(|b| b.set_float(SectionKind::Certificate, index, f32::NAN));
        let error = envelope_error(Kind::Float, SectionKind::Certificate);
        assert_eq!(refused, Err(FileError { index: index as u32, ..error }));
    }
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
    for found in [0, 4, 255, 257, u32::MAX] {
        let refused = FileError { found, ..envelope_error(Kind::Unsupported, section) };
        assert_eq!(edited(|b| b.set_word(section, 0, found)), Err(refused));
    }
}

#[test]
fn a_skin_follows_an_envelope_or_nothing() {
    let section = SectionKind::SkinCounts;
    let follow = |found| edited(|b| b.set_word(section, 2, found));
    assert_eq!(follow(0), Ok(()));
    // Itself, no part, beyond what a row can name.
    for found in [1, 2, 65_535, 65_536, u32::MAX - 1] {
        let refused =
            FileError { index: 2, expected: 2, found, ..skin_error(Kind::Index, section) };
        assert_eq!(follow(found), Err(refused));
    }
    // A part that a reader skips, even if its sections are an envelope's.
    let skipped = edited(|b| {
        b.parts[0] = PartRow { kind: 9, flags: 0 };
    });
    let error = FileError { index: 2, expected: 2, ..skin_error(Kind::Index, section) };
    assert_eq!(skipped, Err(error));
    // Nothing, but with influences; and with sections that only influences have.
    let refused = FileError { index: 1, found: 2, ..skin_error(Kind::Limit, section) };
    assert_eq!(follow(NO_ENVELOPE), Err(refused));
    let mut loose = Builder::loose(SMALL);
    assert!(exercise(&loose.bytes()).is_some());
    loose.sections.push(Content::new(SectionKind::InfluenceWeights, 0, Vec::new()));
    let found = error_of(&loose);
    assert_eq!(
        (found.kind, found.section),
        (Kind::Unexpected, Some(SectionKind::InfluenceWeights))
    );
    // An envelope that stands after its skin.
    let mut late = Builder::several();
    late.parts.swap(0, 1);
    for content in &mut late.sections {
        content.part = [1, 0, 2, 3, 4][usize::from(content.part)];
    }
    late.set_word(section, 2, 1);
    exercise(&late.bytes()).unwrap();
    // The palette of the other one is longer: its skin's boxes and indices tell them apart.
    let mut other = Builder::several();
    other.set_word(section, 2, 2);
    let found = error_of(&other);
    assert_eq!((found.kind, found.section), (Kind::Length, Some(SectionKind::RestBoxes)));
}

fn error_of(builder: &Builder) -> FileError {
    error(&builder.bytes())
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
    // Diagonal entries squared, then a product of two rows.
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
            for (at, value) in values.iter().enumerate() {
                b.set_float(section, values.len() * vertex + at, *value);
            }
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

    let weight = |value| edited(|b| b.set_float(SectionKind::InfluenceWeights, 4, value));
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

#[test]
fn errors_say_what_is_wrong_in_a_phrase() {
    let phrase = |edit: &dyn Fn(&mut Builder)| edited(edit).unwrap_err().to_string();
    assert_eq!(
        phrase(&|b| b.set_half(SectionKind::InfluenceIndices, 5, 3)),
        "part 1: index 5 of influence_indices: expected less than 3, found 3"
    );
    assert_eq!(
        phrase(&|b| b.set_word(SectionKind::EnvelopeCounts, 1, 0)),
        "part 0: joints: expected at least 1, found 0"
    );
    assert_eq!(
        phrase(&|b| b.parts.push(PartRow { kind: 5, flags: 1 })),
        "part 2: unknown required kind, type or flags: 5"
    );
}
