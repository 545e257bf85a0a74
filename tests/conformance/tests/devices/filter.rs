//! Filters on real devices: lavapipe has the CPU's bits, others are within the tolerances.

use crate::devices::lavapipe::{same_bits, silent, sum, whole_and_cut, within_tolerances};
use crate::devices::software::{Fault, Software};
use conformance::backend::Failure;
use conformance::filters::{FilterSubject, SIGNALS, files, filters};
use conformance::finding::sound;
use conformance::gpu::Gpu;
use conformance::stages::filter::body;
use sinew_gpu::headless::Device;
use sinew_gpu::layout::{Resource, Stage};

/// Runs every filter; returns the number of values compared, and of those that differ.
fn evaluate(device: &dyn Device, signal_len: usize) -> (usize, usize) {
    sum(filters(signal_len).iter().map(|subject| {
        let blob = subject.model.blob().len().next_multiple_of(4) as u64;
        // Chunks of few signals.
        let bytes = blob.max(24 << 10);
        whole_and_cut(device, bytes, &subject.described(), |gpu| body(gpu, subject))
    }))
}

#[test]
fn a_device_that_is_wrong_about_filters_is_caught() {
    for bytes in files() {
        let subject = FilterSubject::new(bytes, 5, 3);
        let run = |fault| body(&Gpu::new(&Software::new(bytes, fault)), &subject);
        let right = run(None).unwrap();
        assert!(sound(&right) == Ok(()) && right.iter().all(|finding| finding.differing == 0));
        let flipped = run(Some(Fault::Bit(Stage::Filter, Resource::Out, 3))).unwrap();
        assert!(flipped.iter().any(|finding| finding.differing > 0), "one bit");
        let idle = run(Some(Fault::Idle(Stage::Filter))).unwrap();
        assert!(sound(&idle).is_err(), "left alone");
        // Before the first sample, and before the first output.
        for (resource, float) in [(Resource::Samples, 3), (Resource::Out, 1)] {
            let stray = run(Some(Fault::Stray(Stage::Filter, resource, float)));
            assert!(matches!(stray, Err(Failure::Touched { .. })), "{resource:?} {float}");
        }
    }
}

#[test]
fn lavapipe_has_the_bits_of_the_cpu() {
    same_bits(evaluate, SIGNALS, 100_000);
}

#[test]
fn validation_is_silent() {
    silent(evaluate, 7, 30_000);
}

#[test]
fn every_other_device_is_within_the_tolerances() {
    within_tolerances(evaluate, SIGNALS, 100_000);
}
