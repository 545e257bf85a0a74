//! Files cut short, lengthened, flipped and damaged: refused, or harmless.

use crate::common::{apart, exercise, file_error};
use crate::error;
use models::{Pieces, Rng, Shape, seal};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::{FileErrorKind as Kind, Model};

#[test]
fn every_truncation_is_refused() {
    let bytes = Pieces::small(Predictor::Rotational).bytes();
    for len in (0..bytes.len()).step_by(apart(199)) {
        assert_eq!(error(&bytes[..len]), file_error(Kind::Malformed), "{len}");
        let mut sealed = bytes[..len].to_vec();
        seal(&mut sealed);
        assert!(exercise(&sealed).is_none(), "{len}");
    }
}

#[test]
fn extra_bytes_are_refused() {
    let mut bytes = Pieces::small(Predictor::Rotational).bytes();
    bytes.push(0);
    seal(&mut bytes);
    assert_eq!(error(&bytes), file_error(Kind::Malformed));
}

#[test]
fn every_flipped_bit_is_refused_and_harmless_when_sealed() {
    let shape = Shape {
        vertices: 2,
        joints: 3,
        proxies: 2,
        influences: 2,
        tangents: true,
        coefficients: true,
    };
    let bytes = Pieces::sample(Predictor::Rotational, shape).bytes();
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
    let mut below = |n: usize| (rng.next_u64() % n as u64) as usize;
    let bytes = Pieces::small(Predictor::Rotational).bytes();
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
