//! Shapes on real devices: lavapipe has the CPU's bits, others are within the tolerances.

use crate::devices::lavapipe::{same_bits, silent, sum, whole_and_cut, within_tolerances};
use crate::devices::software::{Fault, Software};
use conformance::backend::Failure;
use conformance::finding::sound;
use conformance::gpu::Gpu;
use conformance::shapes::{FACES, ShapeSubject, files, shapes};
use conformance::stages::shapes::body;
use sinew_gpu::headless::Device;
use sinew_gpu::layout::{Resource, Stage};

/// Runs every skin; returns the number of values compared, and of those that differ.
fn evaluate(device: &dyn Device, face_len: usize) -> (usize, usize) {
    sum(shapes(face_len).iter().map(|subject| {
        let blob = subject.model.blob().len().next_multiple_of(4) as u64;
        let mesh = 44 * subject.skin.vertex_len() as u64 + 300;
        // Chunks of few faces.
        let bytes = blob.max(2 * mesh);
        whole_and_cut(device, bytes, &subject.described(), |gpu| body(gpu, subject))
    }))
}

#[test]
fn the_runtime_behind_the_trait_gives_the_runtimes_bits() {
    for bytes in files() {
        let subject = ShapeSubject::new(bytes, 5);
        let findings = body(&Gpu::new(&Software::new(bytes, None)), &subject).unwrap();
        assert_eq!(sound(&findings), Ok(()), "{}", subject.described());
        assert!(findings.iter().all(|finding| finding.differing == 0));
    }
}

#[test]
fn a_device_that_is_wrong_about_shapes_is_caught() {
    for bytes in files() {
        let subject = ShapeSubject::new(bytes, 5);
        let run = |fault| body(&Gpu::new(&Software::new(bytes, Some(fault))), &subject);
        let flipped = run(Fault::Bit(Stage::Shapes, Resource::Out, 1)).unwrap();
        assert!(flipped.last().is_some_and(|range| range.differing > 0), "the range's first float");
        let idle = run(Fault::Idle(Stage::Shapes)).unwrap();
        assert!(sound(&idle).is_err(), "left alone");
        // A float before the weights, or a weight; before the first attribute of the range.
        for (resource, float) in
            [(Resource::Weights, 3), (Resource::Weights, 7), (Resource::Out, 0)]
        {
            let stray = run(Fault::Stray(Stage::Shapes, resource, float));
            let is_seen = match &stray {
                Ok(findings) => sound(findings).is_err(),
                Err(failure) => matches!(failure, Failure::Touched { .. }),
            };
            assert!(is_seen || subject.skin.shape_len() == 0, "{resource:?} {float}: {stray:?}");
        }
    }
}

#[test]
fn lavapipe_has_the_bits_of_the_cpu() {
    same_bits(evaluate, FACES, 1_000_000);
}

#[test]
fn validation_is_silent() {
    silent(evaluate, 7, 100_000);
}

#[test]
fn every_other_device_is_within_the_tolerances() {
    within_tolerances(evaluate, FACES, 1_000_000);
}
