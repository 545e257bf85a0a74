//! Files that must load and files that must not.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{Builder, Content, Rng, SMALL, Shape, apart, exercise, seal};
use sinew_runtime::format::{
    CHECKSUM_OFFSET, EnvelopeCounts, MAGIC, PartRow, Predictor, Presence, SectionKind, SectionRow,
};
use sinew_runtime::{FormatError, Limits, Model, Quantity};

fn error(bytes: &[u8]) -> FormatError {
    Model::from_bytes(bytes).unwrap_err()
}

/// Loads a sample that `edit` has changed.
fn edited(edit: impl FnOnce(&mut Builder)) -> Result<(), FormatError> {
    let mut builder = Builder::small(Predictor::Rotational);
    edit(&mut builder);
    Model::from_bytes(&builder.bytes()).map(|_| ())
}

#[test]
fn a_sound_file_loads_at_any_address_and_alignment() {
    for alignment_log2 in (4..=12).step_by(apart(9)) {
        // Further rows shift the blob's start through many residues.
        for further in (0..=19).step_by(apart(19)) {
            let mut builder = Builder::small(Predictor::Rotational);
            builder.alignment_log2 = alignment_log2;
            let content = |kind| Content { kind, part: 0, flags: 0, bytes: vec![1; 5] };
            builder.sections.extend((900..900 + further).map(content));
            let bytes = builder.bytes();
            exercise(&bytes).unwrap();
            let shifted = [&[0], bytes.as_slice()].concat();
            exercise(&shifted[1..]).unwrap();
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
    let model = shared(Model::from_bytes(&bytes).unwrap());
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
    assert_eq!(envelope.influences(1).collect::<Vec<_>>(), [(1, 0.75), (2, 0.25)]);
    assert_eq!(envelope.influences(usize::MAX).len(), 0);
    assert_eq!(envelope.certificate().lbs_training_rms, 0.04);
    assert!(model.envelope_named("arm").is_some() && model.envelope_named("leg").is_none());
    assert_eq!((model.parts().len(), model.sections().len()), (1, 13));
}

#[test]
fn every_truncation_is_refused() {
    let bytes = Builder::small(Predictor::Rotational).bytes();
    for len in (0..bytes.len()).step_by(apart(199)) {
        assert_eq!(error(&bytes[..len]), FormatError::Malformed, "{len}");
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
    assert_eq!(error(&bytes), FormatError::TrailingBytes { found: 1 });
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
            let span = if below(2) == 0 { 260 } else { bytes.len() };
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
    let found = *b"SNEX";
    assert_eq!(edited(|b| b.magic = found), Err(FormatError::Magic { found }));
    for found in [0, 1, 3] {
        let version = FormatError::Version { expected: 2, found };
        assert_eq!(edited(|b| b.version = found), Err(version));
    }
    let features = FormatError::Features { unknown: 0x8000_0001 };
    assert_eq!(edited(|b| b.features = 0x8000_0001), Err(features));
    for log2 in [0, 3, 13, 63, 255].into_iter().step_by(apart(5)) {
        assert_eq!(edited(|b| b.alignment_log2 = log2), Err(FormatError::Alignment { log2 }));
    }
    let builder = Builder::small(Predictor::Rotational);
    let sum = |bytes: &[u8]| u32::from_le_bytes(*bytes[CHECKSUM_OFFSET..].first_chunk().unwrap());
    let mut bytes = builder.bytes();
    let expected = sum(&bytes) ^ 1;
    bytes[CHECKSUM_OFFSET] ^= 1;
    assert_eq!(error(&bytes), FormatError::Checksum { expected, found: expected ^ 1 });

    static LONG: [u8; 400] = [0; 400];
    let misaligned = builder.bytes_with(|file| file.padding = &LONG[..file.padding.len() + 1]);
    assert_eq!(error(&misaligned), FormatError::Alignment { log2: 4 });
    static ONES: [u8; 400] = [1; 400];
    let padded = builder.bytes_with(|file| file.padding = &ONES[..file.padding.len() + 16]);
    assert_eq!(error(&padded), FormatError::Padding);
    assert_eq!(error(b""), FormatError::Malformed);
    assert_eq!(error(&MAGIC), FormatError::Malformed);
}

#[test]
fn each_field_of_the_tables_is_checked() {
    let row = Builder::small(Predictor::Rotational).parts[0];
    assert_eq!(edited(|b| b.parts.clear()), Err(FormatError::PartTable { bytes: 0 }));
    let nine = FormatError::PartTable { bytes: 9 * PartRow::BYTES };
    assert_eq!(edited(|b| b.parts = vec![row; 9]), Err(nine));
    let unknown = |kind, flags| PartRow { kind, flags, ..row };
    for kind in [0, 2, 3, 4, 5, 255] {
        let refused = FormatError::UnknownPart { kind };
        assert_eq!(edited(|b| b.parts.push(unknown(kind, 1))), Err(refused));
        assert_eq!(edited(|b| b.parts.push(unknown(kind, 0))), Ok(()));
    }
    assert_eq!(edited(|b| b.parts[0].flags = 3), Err(FormatError::Flags { found: 3 }));

    let extra = |kind, part, flags| Content { kind, part, flags, bytes: vec![0; 5] };
    assert_eq!(edited(|b| b.sections.push(extra(999, 0, 0))), Ok(()));
    assert_eq!(
        edited(|b| b.sections.push(extra(999, 0, 1))),
        Err(FormatError::UnknownSection { kind: 999 })
    );
    assert_eq!(
        edited(|b| {
            b.parts.push(unknown(9, 0));
            b.sections.push(extra(999, 1, 1));
        }),
        Ok(()),
        "sections of a skipped part are skipped"
    );
    assert_eq!(edited(|b| b.sections.push(extra(999, 0, 2))), Err(FormatError::Flags { found: 2 }));
    assert_eq!(
        edited(|b| b.sections.push(extra(999, 1, 0))),
        Err(FormatError::SectionPart { row: 13, found: 1 })
    );
    assert_eq!(
        edited(|b| b.sections.push(extra(5, 0, 1))),
        Err(FormatError::DuplicateSection { row: 13 })
    );
    let many = FormatError::SectionTable { bytes: 33 * SectionRow::BYTES };
    assert_eq!(edited(|b| b.sections.extend((13..33).map(|i| extra(900 + i, 0, 0)))), Err(many));
    let rows = |edit| edited(|b| b.edit_rows = edit);
    assert_eq!(rows(|r| r[3].offset += 4), Err(FormatError::SectionAlignment { row: 3 }));
    assert_eq!(rows(|r| r[3].offset = 0), Err(FormatError::SectionOverlap { row: 3 }));
    assert_eq!(rows(|r| r[3].bytes += 64), Err(FormatError::SectionOverlap { row: 4 }));
    assert_eq!(rows(|r| r[12].offset += 1 << 20), Err(FormatError::SectionBounds { row: 12 }));
    assert_eq!(rows(|r| r[12].bytes = u32::MAX), Err(FormatError::SectionBounds { row: 12 }));
    assert_eq!(rows(|r| r.swap(3, 4)), Err(FormatError::SectionOverlap { row: 4 }));

    let builder = Builder::small(Predictor::Rotational);
    let odd = builder.bytes_with(|file| {
        file.parts = &file.parts[1..];
        file.padding = &[0; 32][..file.padding.len() + 1];
    });
    assert_eq!(error(&odd), FormatError::PartTable { bytes: PartRow::BYTES - 1 });
    let odd = builder.bytes_with(|file| {
        file.sections = &file.sections[1..];
        file.padding = &[0; 32][..file.padding.len() + 1];
    });
    assert_eq!(error(&odd), FormatError::SectionTable { bytes: 13 * SectionRow::BYTES - 1 });
}

#[test]
fn each_section_is_required_and_has_its_length() {
    for (predictor, section) in
        Predictor::ALL.into_iter().flat_map(|p| SectionKind::ALL.map(|section| (p, section)))
    {
        let edited = |edit: &dyn Fn(&mut Builder)| {
            let mut builder = Builder::small(predictor);
            edit(&mut builder);
            Model::from_bytes(&builder.bytes()).map(|_| ())
        };
        if section.presence(predictor) == Presence::Absent {
            let bytes = vec![0; 4];
            let extra = Content { kind: section.number(), part: 0, flags: 0, bytes };
            let unexpected = FormatError::UnexpectedSection { section };
            assert_eq!(edited(&|b| b.sections.push(extra.clone())), Err(unexpected));
            continue;
        }
        let without = edited(&|b| b.sections.retain(|content| content.kind != section.number()));
        let optional = section.presence(predictor) == Presence::Optional;
        let missing = FormatError::MissingSection { section };
        assert_eq!(without, if optional { Ok(()) } else { Err(missing) });
        for change in [-1, 1] {
            let refused = edited(&|b| {
                let len = b.section(section).len().wrapping_add_signed(change);
                b.section(section).resize(len, 0);
            });
            match (section, refused) {
                (SectionKind::Names, Err(FormatError::Name { index: 4 })) => {}
                (_, Err(FormatError::SectionLength { section: found, expected, .. })) => {
                    assert_eq!(found, section);
                    let mut builder = Builder::small(predictor);
                    let counts = builder.parts[0].envelope_counts();
                    let stated = match section {
                        SectionKind::Corrections => Some(builder.section(section).len() as u64),
                        _ => section.bytes(predictor, &counts),
                    };
                    assert_eq!(Some(u64::from(expected)), stated);
                }
                (_, refused) => panic!("{section:?}: {refused:?}"),
            }
        }
    }
    let huge = EnvelopeCounts {
        vertex_len: u32::MAX,
        joint_len: u32::MAX,
        proxy_len: u32::MAX,
        influence_len: u32::MAX,
        root: 0,
        group_len: u32::MAX,
        scratch_len: u32::MAX,
    };
    assert_eq!(SectionKind::C2.bytes(Predictor::Hybrid, &huge), None);
}

#[test]
fn limits_are_honoured() {
    let bytes = Builder::small(Predictor::Rotational).bytes();
    let exact = Limits {
        file_bytes: bytes.len() as u32,
        vertices: SMALL.vertices as u32,
        joints: SMALL.joints as u32,
        proxies: SMALL.proxies as u32,
        influences: SMALL.influences as u32,
    };
    assert!(Model::from_bytes_with(&bytes, &exact).is_ok());
    let refused = |limits: Limits, quantity, most| {
        let found = Model::from_bytes_with(&bytes, &limits).unwrap_err();
        assert_eq!(found, FormatError::Limit { quantity, most, found: most + 1 });
    };
    let less = |x: u32| x - 1;
    let file_bytes = less(exact.file_bytes);
    refused(Limits { file_bytes, ..exact }, Quantity::FileBytes, file_bytes);
    refused(Limits { vertices: 6, ..exact }, Quantity::Vertices, 6);
    refused(Limits { joints: 3, ..exact }, Quantity::Joints, 3);
    refused(Limits { proxies: 2, ..exact }, Quantity::Proxies, 2);
    refused(Limits { influences: 1, ..exact }, Quantity::Influences, 1);
    for (at, quantity) in [(1, Quantity::Joints), (2, Quantity::Proxies), (3, Quantity::Influences)]
    {
        assert_eq!(edited(|b| b.parts[0].counts[at] = 0), Err(FormatError::Empty { quantity }));
    }
    // Limits do not lift what the format cannot hold.
    let mut builder = Builder::small(Predictor::Rotational);
    builder.parts[0].counts[1] = 65_536;
    let unlimited = Limits { joints: u32::MAX, ..Limits::DEFAULT };
    let found = Model::from_bytes_with(&builder.bytes(), &unlimited).unwrap_err();
    let (quantity, most) = (Quantity::Joints, 65_535);
    assert_eq!(found, FormatError::Limit { quantity, most, found: 65_536 });
    // Without vertices, influences cost no bytes.
    let mut builder = Builder::sample(Shape { vertices: 0, tangents: false, ..SMALL });
    let unlimited = Limits { influences: u32::MAX, ..Limits::DEFAULT };
    for (found, expected) in [
        (65_535, Ok(())),
        (65_536, Err(FormatError::Limit { quantity: Quantity::Influences, most, found: 65_536 })),
    ] {
        builder.parts[0].counts[3] = found;
        let loaded = Model::from_bytes_with(&builder.bytes(), &unlimited).map(|_| ());
        assert_eq!(loaded, expected);
    }
}

#[test]
fn each_float_is_checked() {
    let floats = [
        (SectionKind::InverseBinds, 0),
        (SectionKind::RestPositions, 0),
        (SectionKind::RestNormals, 0),
        (SectionKind::RestTangents, 0),
        (SectionKind::InfluenceWeights, 0),
        (SectionKind::Keys, 1),
        (SectionKind::C1, 0),
        (SectionKind::C2, 0),
        (SectionKind::RestBoxes, 0),
        (SectionKind::PoseRanges, 0),
    ];
    for (section, skipped) in floats {
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.1e9, -1.1e9] {
            let refused = edited(|b| b.set_float(section, 3, value));
            let index = 3 - skipped;
            let expected = FormatError::Float { section: Some(section), index };
            assert_eq!(refused, Err(expected), "{section:?} {value}");
        }
    }
    for section in [SectionKind::InfluenceWeights, SectionKind::PoseRanges] {
        let refused = edited(|b| b.set_float(section, 1, -0.25));
        assert_eq!(refused, Err(FormatError::Float { section: Some(section), index: 1 }));
    }
    for index in 0..5 {
        let refused = edited(|b| b.parts[0].figures[index] = f32::NAN);
        assert_eq!(refused, Err(FormatError::Float { section: None, index }));
    }
}

#[test]
fn each_index_is_checked() {
    let section = SectionKind::InfluenceIndices;
    assert_eq!(
        edited(|b| b.set_half(section, 5, 3)),
        Err(FormatError::Index { section, index: 5, below: 3, found: 3 })
    );
    let section = SectionKind::Keys;
    for joint in [0, 1] {
        assert_eq!(
            edited(|b| b.set_half(section, 110 + joint, 4)),
            Err(FormatError::Index { section, index: 1, below: 4, found: 4 })
        );
    }
    assert_eq!(
        edited(|b| b.set_half(section, 0, u16::MAX)),
        Err(FormatError::Index { section, index: 0, below: 4, found: 65_535 }),
        "a key must have a joint"
    );
    for found in [0, 4, 255] {
        assert_eq!(edited(|b| b.parts[0].predictor = found), Err(FormatError::Predictor { found }));
    }
}

#[test]
fn the_hierarchy_is_one_tree() {
    let hierarchy = SectionKind::Hierarchy;
    let refused = |at, value| edited(|b| b.set_half(hierarchy, at, value));
    let wrong = |joint| Err(FormatError::Hierarchy { joint });
    // Parents of 0..4 are 2, none, 1, 0; the order is 1, 2, 0, 3; ranks are 2, 0, 1, 3.
    assert_eq!(refused(0, 3), wrong(0), "a cycle");
    assert_eq!(refused(0, 0), wrong(0), "its own parent");
    assert_eq!(refused(0, 4), wrong(0), "no such parent");
    assert_eq!(refused(0, u16::MAX), wrong(0), "a second root");
    assert_eq!(refused(1, 0), wrong(1), "no root");
    assert_eq!(refused(4, 2), wrong(2), "a joint twice");
    assert_eq!(refused(4, 9), wrong(4), "no such joint");
    assert_eq!(refused(8, 3), wrong(0), "a rank of another");
    assert_eq!(edited(|b| b.parts[0].counts[4] = 2), wrong(1), "another root");
    assert_eq!(edited(|b| b.parts[0].counts[4] = 4), wrong(1), "no such root");
}

#[test]
fn inverse_binds_are_rigid() {
    let section = SectionKind::InverseBinds;
    let entry = |at: usize, value| edited(|b| b.set_float(section, 12 + at, value));
    let wrong = Err(FormatError::InverseBind { joint: 1 });
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
fn names_weights_twists_and_boxes_are_checked() {
    let at_text = 4 * 5;
    let not_utf8 = edited(|b| b.section(SectionKind::Names)[at_text] = 0xff);
    assert_eq!(not_utf8, Err(FormatError::Name { index: 0 }));
    let backwards = edited(|b| b.section(SectionKind::Names)[4] = 0);
    assert_eq!(backwards, Err(FormatError::Name { index: 1 }));
    let beyond = edited(|b| b.section(SectionKind::Names)[16] = 200);
    assert_eq!(beyond, Err(FormatError::Name { index: 4 }));

    let weight = |value| edited(|b| b.set_float(SectionKind::InfluenceWeights, 4, value));
    assert_eq!(weight(0.75 + 9e-6), Ok(()));
    assert_eq!(weight(0.75 + 1.2e-5), Err(FormatError::Weights { vertex: 2 }));
    assert_eq!(weight(0.75 - 1.2e-5), Err(FormatError::Weights { vertex: 2 }));

    for at in [55 + 1, 55 + 10] {
        let twist = |value| edited(|b| b.set_float(SectionKind::Keys, at, value));
        assert_eq!(twist(1000.0), Ok(()));
        assert_eq!(twist(1025.0), Err(FormatError::Twist { key: 1 }));
    }
    let shrunk = edited(|b| b.set_float(SectionKind::RestBoxes, 3, -2.5));
    assert_eq!(shrunk, Err(FormatError::RestBox { index: 0, vertex: 0 }));
}

#[test]
fn errors_say_what_is_wrong_in_a_phrase() {
    let refused = edited(|b| b.set_half(SectionKind::InfluenceIndices, 5, 3)).unwrap_err();
    assert_eq!(refused.to_string(), "index 5 of influence_indices: expected less than 3, found 3");
}
