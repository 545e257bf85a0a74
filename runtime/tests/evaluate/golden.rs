//! The golden files stay loadable, and their evaluation has equal bits on every CPU.

// A hash over all poses takes hours under Miri. The other tests cover the code there.
#![cfg(not(miri))]

#[path = "../../../tests/golden/bits.rs"]
mod bits;

use bits::{Found, GOLDEN, Golden, Memory, STAGES, filters, kernels, priors, views};
use models::{
    FACE_NAME, FilterContent, KernelContent, Pieces, SHAPED_NAMES, TURNED_NAMES, VIEWED_NAMES,
    golden_path,
};
use sinew_runtime::{Envelope, Filter, KernelMap, Model, Prior, Skin, Views};

fn hashes(golden: &Golden, nudge: f32) -> Found {
    let model = Model::from_bytes(golden.file).unwrap();
    let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
    assert_eq!(envelope.predictor(), golden.predictor);
    bits::hashes(envelope, skin, bits::POSES, nudge, &mut Box::new(Memory::new())).unwrap()
}

#[test]
fn bits_are_those_of_every_other_cpu() {
    let mut all = Vec::new();
    for golden in &GOLDEN {
        let found = hashes(golden, 0.0);
        assert!(found.faded > 100, "{}: {} poses in the fade", golden.name, found.faded);
        assert!(found.finite, "{}", golden.name);
        all.push(found.bits);
    }
    assert_eq!(all, GOLDEN.map(|golden| golden.bits), "found {all:#018x?}");
}

#[test]
fn the_hash_sees_one_last_place() {
    for golden in &GOLDEN {
        let nudged = hashes(golden, 1.2e-7).bits;
        for ((stage, nudged), bits) in STAGES.iter().zip(nudged).zip(golden.bits) {
            assert!(nudged != bits || bits == 0, "{stage} of {}", golden.name);
        }
    }
}

fn kernel_hashes(nudge: f32) -> Vec<u64> {
    let model = kernels::load().unwrap();
    let (mut scratch, mut out) = ([0.0; 1024], [0.0; 128]);
    let hash = |map| kernels::hash(&map, nudge, &mut scratch, &mut out).unwrap();
    model.all::<KernelMap>().map(hash).collect()
}

#[test]
fn bits_of_kernels_are_those_of_every_other_cpu() {
    let found = kernel_hashes(0.0);
    assert_eq!(found, kernels::BITS, "found {found:#018x?}");
}

#[test]
fn the_hash_of_kernels_sees_one_last_place() {
    let nudged = kernel_hashes(1.2e-7);
    assert_eq!(nudged.len(), kernels::BITS.len());
    assert!(nudged.iter().zip(kernels::BITS).all(|(nudged, bits)| *nudged != bits));
}

fn views_hashes(nudge: f32) -> [u64; 2] {
    views::VIEWS.map(|file| {
        let model = views::load(file).unwrap();
        views::hash(&model, model.first::<Views>().unwrap(), nudge, &mut [0.0; 256]).unwrap()
    })
}

#[test]
fn bits_of_views_are_those_of_every_other_cpu() {
    let found = views_hashes(0.0);
    assert_eq!(found, views::BITS, "found {found:#018x?}");
}

#[test]
fn the_hash_of_views_sees_one_last_place() {
    let nudged = views_hashes(1.2e-7);
    assert!(nudged.iter().zip(views::BITS).all(|(nudged, bits)| *nudged != bits));
}

fn filter_hash(nudge: f32) -> u64 {
    let model = filters::load().unwrap();
    let filter = model.first::<Filter>().unwrap();
    filters::hash(&filter, nudge, &mut [0.0; 128], &mut [0.0; 512]).unwrap()
}

#[test]
fn bits_of_a_filter_are_those_of_every_other_cpu() {
    let found = filter_hash(0.0);
    assert_eq!(found, filters::BITS, "found {found:#018x}");
}

#[test]
fn the_hash_of_a_filter_sees_one_last_place() {
    assert_ne!(filter_hash(1.2e-7), filters::BITS);
}

fn prior_hash(nudge: f32) -> u64 {
    let model = priors::load().unwrap();
    priors::hash(model.first::<Prior>().unwrap(), model.first::<Skin>().unwrap(), nudge).unwrap()
}

#[test]
fn bits_of_pins_are_those_of_every_other_cpu() {
    let found = prior_hash(0.0);
    assert_eq!(found, priors::BITS, "found {found:#018x}");
}

#[test]
fn the_hash_of_pins_sees_one_last_place() {
    assert_ne!(prior_hash(1.2e-7), priors::BITS);
}

/// Environment variable: write the golden files instead of comparing them.
const WRITE: &str = "SINEW_WRITE_GOLDEN";

#[test]
fn the_golden_parts_are_reproduced() {
    let kernels =
        [KernelContent::goldens().as_slice(), &[KernelContent::servo()]].map(Pieces::kernels);
    let names = ["kernel-11.snw", "kernel-11-servo.snw"].into_iter().chain(TURNED_NAMES);
    let names = names.chain(SHAPED_NAMES).chain(VIEWED_NAMES).chain([FACE_NAME]);
    let names = names.chain(["filter-11.snw", "several-11.snw"]);
    let all = kernels.into_iter().chain(Pieces::turned()).chain(Pieces::shaped());
    let all = all.chain(Pieces::viewed()).chain([Pieces::face()]);
    let all = all.chain([Pieces::filter(&FilterContent::sensor()), Pieces::several()]);
    for (name, pieces) in names.zip(all) {
        let made = pieces.bytes();
        if std::env::var_os(WRITE).is_some() {
            std::fs::write(golden_path(name), &made).unwrap();
        }
        assert!(std::fs::read(golden_path(name)).unwrap() == made, "{name} is made of other bytes");
    }
}
