//! The message: head, padding, space; and the text of a refusal.

use crate::common::{exercise, file_error};
use crate::format::{edited, error};
use models::{Pieces, head};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::{
    Axis, CHECKSUM_OFFSET, Handedness, MAGIC, PartRow, SectionKind, SectionRow, Space,
};
use sinew_runtime::{FileError, FileErrorKind as Kind, Model};

#[test]
fn each_field_of_the_head_is_checked() {
    let word = u32::from_le_bytes;
    let found = *b"SNEX";
    let refused =
        FileError { expected: word(MAGIC), found: word(found), ..file_error(Kind::NotAModel) };
    assert_eq!(edited(|b| b.head[head::MAGIC].copy_from_slice(&found)), Err(refused));
    for version in [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12] {
        let refused =
            FileError { expected: 11, found: version.into(), ..file_error(Kind::Version) };
        assert_eq!(edited(|b| b.head[head::VERSION] = version), Err(refused));
    }
    let refused = FileError { found: 0x8000_0001, ..file_error(Kind::Unsupported) };
    assert_eq!(edited(|b| b.head[head::FEATURES].copy_from_slice(&[1, 0, 0, 0x80])), Err(refused));
    let pieces = Pieces::small(Predictor::Rotational);
    let sum = |bytes: &[u8]| u32::from_le_bytes(*bytes[CHECKSUM_OFFSET..].first_chunk().unwrap());
    let mut bytes = pieces.bytes();
    let expected = sum(&bytes) ^ 1;
    bytes[CHECKSUM_OFFSET] ^= 1;
    let refused = FileError { expected, found: expected ^ 1, ..file_error(Kind::Checksum) };
    assert_eq!(error(&bytes), refused);

    let model_blob = Model::from_bytes(pieces.bytes()).unwrap().blob().len();
    let longer =
        |by: usize| pieces.bytes_with(|file| file.padding.resize(file.padding.len() + by, 0));
    let start = |file: &[u8]| (file.len() - model_blob) as u32;
    let off = |file: &[u8]| FileError {
        index: 3,
        expected: 16,
        found: start(file),
        ..file_error(Kind::Malformed)
    };
    assert_eq!(error(&longer(1)), off(&longer(1)), "a blob off its alignment");
    exercise(&longer(16)).unwrap();
    let padded = pieces.bytes_with(|file| file.padding = vec![1; file.padding.len() + 16]);
    assert_eq!(error(&padded), off(&padded));
    let head = FileError { expected: 21, ..file_error(Kind::Truncated) };
    assert_eq!(error(b""), head);
    assert_eq!(error(&MAGIC), FileError { found: 4, ..head });
}

#[test]
fn each_byte_of_the_space_is_checked() {
    let load = |space: [u8; 8]| {
        let mut pieces = Pieces::small(Predictor::Rotational);
        pieces.head[head::SPACE].copy_from_slice(&space);
        Model::from_bytes(pieces.bytes()).map(|model| model.space())
    };
    let none = || std::iter::once(None);
    let axes = || none().chain(Axis::ALL.map(Some));
    for (up, forward) in axes().flat_map(|up| axes().map(move |forward| (up, forward))) {
        for handedness in [Handedness::Right, Handedness::Left] {
            for unit in [None, Some(0.01), Some(1e-9), Some(1e9)] {
                let space = Space { up, forward, handedness, unit };
                let along = up.zip(forward).is_some_and(|(up, forward)| up.is_along(forward));
                let found = forward.map_or(0, Axis::number).into();
                let wrong = FileError { index: 1, found, ..file_error(Kind::Space) };
                let expected = if along { Err(wrong) } else { Ok(space) };
                assert_eq!(load(space.to_bytes()), expected);
            }
        }
    }
    let sound = Space { up: Some(Axis::Y), forward: Some(Axis::Z), ..Space::default() }.to_bytes();
    assert_eq!(sound, [3, 5, 1, 0, 0, 0, 0, 0]);
    let wrong =
        |index, found: u8| Err(FileError { index, found: found.into(), ..file_error(Kind::Space) });
    for (at, value) in [(0, 7), (0, 255), (1, 7), (1, 4), (2, 0), (2, 3), (3, 1), (3, 255)] {
        let mut space = sound;
        space[at] = value;
        assert_eq!(load(space), wrong(at as u32, value), "{at} {value}");
    }
    for unit in [f32::NAN, f32::INFINITY, -1.0, -0.0, 9e-10, 1.1e9, 1e-45] {
        let mut space = sound;
        space[4..].copy_from_slice(&unit.to_le_bytes());
        assert_eq!(load(space), wrong(4, space[4]), "{unit}");
    }
}

#[test]
fn errors_say_what_is_wrong_in_a_phrase() {
    let phrase = |edit: &dyn Fn(&mut Pieces)| edited(edit).unwrap_err().to_string();
    assert_eq!(
        phrase(&|b| b.set_half(SectionKind::InfluenceIndices, 5, 3)),
        "part 1: index 5 of influence_indices: expected less than 3, found 3"
    );
    assert_eq!(
        phrase(&|b| b.set_word(SectionKind::EnvelopeCounts, 1, 0)),
        "part 0: joints: expected at least 1, found 0"
    );
    assert_eq!(
        phrase(&|b| b.parts.push(PartRow { kind: 9, flags: 1 })),
        "part 2: unknown required kind, type or flags: 9"
    );
    let bytes = Pieces::small(Predictor::Rotational).bytes();
    let cut = |len: usize| error(&bytes[..len]).to_string();
    assert_eq!(cut(0), "the file ends early, in its head: expected at least 21 bytes, found 0");
    assert_eq!(
        cut(25),
        "the file ends early, in its part table: expected at least 30 bytes, found 25"
    );
    assert_eq!(
        cut(bytes.len() - 1),
        "part 1: the file ends early: section normal_errors: expected 12 bytes, found 11"
    );
    let space = phrase(&|b| b.head[head::SPACE.start] = 9);
    assert_eq!(space, "byte 0 of the space: 9 is not valid");
    let longer = Pieces::small(Predictor::Rotational).bytes_with(|file| {
        file.parts.remove(0);
        file.padding.push(0);
    });
    assert_eq!(
        error(&longer).to_string(),
        "the part table: expected rows of 4 bytes, found 7 bytes"
    );
    let rows = |edit: fn(&mut [SectionRow])| {
        error(&Pieces::small(Predictor::Rotational).bytes_with_rows(edit)).to_string()
    };
    let said = rows(|rows| rows[19].bytes += 64);
    assert!(said.contains("reaches beyond the blob: expected an end of at most"), "{said}");
}
