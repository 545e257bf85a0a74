//! Files cut short, lengthened, flipped and damaged: refused or harmless.

use crate::common::{apart, exercise, file_error};
use crate::format::error;
use models::{Pieces, Rng, Shape, TINY, head, seal};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::{SectionKind, SectionRow};
use sinew_runtime::{FileError, FileErrorKind as Kind, Model};

/// Error of a file cut after `len` bytes, by its own tables. A length of 128 or more takes two
/// bytes.
fn cut(file: &[u8], len: usize) -> FileError {
    let model = Model::from_bytes(file).unwrap();
    let sections: Vec<_> = model.sections().map(|section| section.row).collect();
    let (parts, rows, blob) = (4 * model.parts().len(), 16 * sections.len(), model.blob().len());
    assert!(parts < 128 && rows >= 128 && blob >= 128);
    let whole = FileError { found: len as u32, ..file_error(Kind::Truncated) };
    // Start and end of each string's content; the last string is the blob.
    let (padding, blob_bytes) = (file.len() - blob, if blob < 1 << 14 { 2 } else { 3 });
    let parts = (head::BYTES + 1, head::BYTES + 1 + parts);
    let rows = (parts.1 + 2, parts.1 + 2 + rows);
    let padding = (rows.1 + 1, padding - blob_bytes);
    for (index, (start, end)) in
        [(head::BYTES, head::BYTES), parts, rows, padding].into_iter().enumerate()
    {
        if len < end {
            let expected = if len < start { len + 1 } else { end };
            let expected = if index == 0 { end } else { expected } as u32;
            return FileError { index: index as u32, expected, ..whole };
        }
    }
    let start = file.len() - blob;
    let left = |row: &SectionRow| len.saturating_sub(start + row.offset as usize) as u32;
    let row = sections.iter().find(|row| left(row) < row.bytes).unwrap();
    FileError {
        part: Some(row.part),
        section: SectionKind::from_number(row.kind),
        expected: row.bytes,
        found: left(row),
        ..whole
    }
}

#[test]
fn every_truncation_is_refused_and_says_where_it_ends() {
    let bytes = Pieces::small(Predictor::Rotational).bytes();
    for len in (0..bytes.len()).step_by(apart(199)) {
        let refused = error(&bytes[..len]);
        assert_eq!(refused, cut(&bytes, len), "{len}");
        assert!(refused.expected > refused.found, "{refused}");
        let mut sealed = bytes[..len].to_vec();
        seal(&mut sealed);
        assert!(exercise(&sealed).is_none(), "{len}");
    }
}

#[test]
fn extra_bytes_are_refused() {
    let mut bytes = Pieces::small(Predictor::Rotational).bytes();
    let expected = bytes.len() as u32;
    bytes.push(0);
    seal(&mut bytes);
    let values =
        FileError { index: 4, expected, found: expected + 1, ..file_error(Kind::Malformed) };
    assert_eq!(error(&bytes), values);
    assert!(values.to_string().starts_with("the file: expected "), "{values}");
}

#[test]
fn every_flipped_bit_is_refused_and_harmless_when_sealed() {
    for (predictor, shape) in [
        (Predictor::Rotational, TINY),
        (Predictor::Rotational, Shape { stretches: true, ..TINY }),
        (Predictor::Kernel, Shape { stretches: true, curves: 2, ..TINY }),
        (Predictor::Kernel, Shape { joints: 0, curves: 2, ..TINY }),
    ] {
        flipped_bits(&Pieces::sample(predictor, shape).bytes());
    }
}

fn flipped_bits(bytes: &[u8]) {
    let mut loaded = 0;
    for bit in (0..8 * bytes.len()).step_by(apart(499)) {
        let mut flipped = bytes.to_vec();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(Model::from_bytes(&flipped).is_err(), "{bit}");
        seal(&mut flipped);
        loaded += usize::from(exercise(&flipped).is_some());
    }
    // Mostly low bits of floats. Control: the second half of the test has evaluated files.
    assert!(loaded > bytes.len() / apart(499), "{loaded}");
}

#[test]
fn random_damage_is_harmless() {
    let mut rng = Rng(99);
    let mut below = |n: usize| (rng.next_u64() % n as u64) as usize;
    let bytes = Pieces::small(Predictor::Rotational).bytes();
    for _ in (0..20_000).step_by(apart(1999)) {
        let mut damaged = bytes.clone();
        // Half of the damage goes to the head and the tables, where each byte matters most.
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
