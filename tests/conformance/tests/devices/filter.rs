//! Filters on real devices: lavapipe has the CPU's bits, others are within the tolerances.

use crate::batches;
use crate::software::{Fault, Software};
use conformance::backend::Failure;
use conformance::filters::{FilterSubject, SIGNALS, files, filters};
use conformance::finding::sound;
use conformance::gpu::Gpu;
use conformance::stages::filter::body;
use sinew_gpu::headless::Device;
use sinew_gpu::layout::{DeviceLimits, Resource, Stage};

/// Runs every filter; returns the values compared, and how many differ.
fn evaluate(device: &dyn Device, signal_len: usize) -> (usize, usize) {
    let (mut values, mut differing) = (0, 0);
    for subject in filters(signal_len) {
        // The second cuts batches into chunks of few signals.
        let blob = subject.model.blob().len().next_multiple_of(4) as u64;
        let cut = DeviceLimits { storage_binding_bytes: blob.max(24 << 10), ..device.limits() };
        for limits in [device.limits(), cut] {
            let findings = body(&Gpu { device, limits }, &subject);
            let findings = findings.unwrap_or_else(|e| panic!("{}: {e}", subject.described()));
            assert_eq!(sound(&findings), Ok(()), "{}", subject.described());
            for finding in findings {
                values += finding.values;
                differing += finding.differing;
            }
        }
    }
    (values, differing)
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
        // Before the first sample, and before the first that is written.
        for (resource, float) in [(Resource::Samples, 3), (Resource::Out, 1)] {
            let stray = run(Some(Fault::Stray(Stage::Filter, resource, float)));
            assert!(matches!(stray, Err(Failure::Touched { .. })), "{resource:?} {float}");
        }
    }
}

#[test]
fn lavapipe_has_the_bits_of_the_cpu() {
    batches::same_bits(evaluate, SIGNALS, 100_000);
}

#[test]
fn validation_is_silent() {
    batches::silent(evaluate, 7, 30_000);
}

#[test]
fn every_other_device_is_within_the_tolerances() {
    batches::within_tolerances(evaluate, SIGNALS, 100_000);
}
