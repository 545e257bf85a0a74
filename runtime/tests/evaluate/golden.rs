//! The golden files stay loadable, and their evaluation has the same bits on every CPU.

// A hash takes all its poses, which is hours under Miri; the other tests walk the same code there.
#![cfg(not(miri))]

#[path = "../../../tests/golden/bits.rs"]
mod bits;

use bits::{Found, GOLDEN, Golden, Memory, STAGES};
use sinew_runtime::Model;

fn hashes(golden: &Golden, nudge: f32) -> Found {
    let model = Model::from_bytes(golden.file).unwrap();
    let (envelope, skin) = (model.envelope().unwrap(), model.skin().unwrap());
    assert_eq!(envelope.predictor(), golden.predictor);
    bits::hashes(envelope, skin, nudge, &mut Box::new(Memory::new())).unwrap()
}

#[test]
fn bits_are_those_of_every_other_cpu() {
    let mut all = Vec::new();
    for golden in &GOLDEN {
        let found = hashes(golden, 0.0);
        assert!(found.faded > 100, "{:?}: {} poses in the fade", golden.predictor, found.faded);
        assert!(found.finite, "{:?}", golden.predictor);
        all.push(found.bits);
    }
    assert_eq!(all, GOLDEN.map(|golden| golden.bits), "found {all:#018x?}");
}

#[test]
fn the_hash_sees_one_last_place() {
    for golden in &GOLDEN {
        let nudged = hashes(golden, 1.2e-7).bits;
        for ((stage, nudged), bits) in STAGES.iter().zip(nudged).zip(golden.bits) {
            assert!(nudged != bits || bits == 0, "{stage} of {:?}", golden.predictor);
        }
    }
}
