//! The script of calls reaches every function, and every status that the header names.

use arbitrary::Unstructured;
use hostile::abi::{function_names, one_call, promises};
use hostile::recipe;
use models::{
    FilterContent, GOLDEN, GOLDEN_STRETCH, JOINTLESS, KernelContent, Pieces, ViewsContent,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::SectionKind;
use sinew_runtime::kernel::Kernel;
use sinew_runtime::views::Layer;
use std::collections::BTreeSet;

#[test]
fn every_function_that_can_fail_is_called() {
    let called = function_names().collect::<BTreeSet<_>>();
    assert_eq!(called, promises().keys().copied().collect());
}

/// Makes an object whose map has a rotation as input, and whose first layer has depth.
fn turned() -> Pieces {
    let mut map = KernelContent::map("walk", 51);
    map.inputs = KernelContent::servo().inputs.split_off(2);
    let mut pieces = Pieces::kernels(&[map]);
    let mut content = ViewsContent::sample(vec![0], false);
    content.layers[0].flags = Layer::DEPTH;
    pieces.add_views(&content);
    pieces
}

#[test]
fn every_status_in_the_header_occurs() {
    let golden = |index: usize| Pieces::of(GOLDEN[index]).unwrap();
    let (mut empty, mut bare, mut loose) = (golden(1), golden(0), golden(0));
    empty.keep_vertices(0);
    bare.sections.retain(|content| content.kind != SectionKind::RestTangents.number());
    loose.loosen();
    let mut files: Vec<_> = GOLDEN.into_iter().chain(GOLDEN_STRETCH).map(<[u8]>::to_vec).collect();
    let jointless = Pieces::sample(Predictor::Kernel, JOINTLESS);
    files.extend([empty, bare, loose, jointless, Pieces::face()].map(|pieces| pieces.bytes()));
    let kernels = [KernelContent::every(Kernel::Quintic), KernelContent::servo()];
    files.extend(kernels.map(|content| Pieces::kernels(&[content]).bytes()));
    files.extend(Pieces::viewed().into_iter().chain([turned()]).map(|pieces| pieces.bytes()));
    files.push(Pieces::filter(&FilterContent::sample(2, 5)).bytes());
    let mut random = ChaCha8Rng::seed_from_u64(139);
    let mut seen = BTreeSet::new();
    for number in 0..800_000 {
        let mut bytes = [0; 160];
        random.fill_bytes(&mut bytes);
        let (script, recipe) = bytes.split_at(96);
        let file =
            files.get(number % (files.len() + 2)).cloned().unwrap_or_else(|| recipe::file(recipe));
        if let Ok((name, status)) = one_call(&mut Unstructured::new(script), &file) {
            seen.insert((name, status as i32));
        }
    }
    for (name, statuses) in promises() {
        for status in statuses.iter().chain(&[0]).filter(|status| **status < 100) {
            assert!(seen.contains(&(name, *status)), "{name} never returned {status}");
        }
    }
}
