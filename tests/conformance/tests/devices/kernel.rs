//! Kernels on real devices: lavapipe has the CPU's bits, others are within the tolerances.

use crate::batches;
use conformance::finding::sound;
use conformance::gpu::Gpu;
use conformance::kernels::{KernelSubject, QUERIES, kernels};
use conformance::stages::kernel::body;
use sinew_gpu::headless::Device;
use sinew_gpu::layout::DeviceLimits;

/// Runs every kernel; returns the values compared, and how many differ.
fn evaluate(device: &dyn Device, query_len: usize) -> (usize, usize) {
    let (mut values, mut differing) = (0, 0);
    let on = |limits: DeviceLimits, subject: &KernelSubject<'_>| {
        let findings = body(&Gpu { device, limits }, subject);
        let findings = findings.unwrap_or_else(|e| panic!("{}: {e}", subject.described()));
        assert_eq!(sound(&findings), Ok(()), "{}", subject.described());
        findings
    };
    for subject in kernels(query_len) {
        // The second cuts batches into chunks of few queries.
        let blob = subject.model.blob().len().next_multiple_of(4) as u64;
        let cut = DeviceLimits { storage_binding_bytes: blob.max(6 << 10), ..device.limits() };
        for limits in [device.limits(), cut] {
            for finding in on(limits, &subject) {
                values += finding.values;
                differing += finding.differing;
            }
        }
    }
    (values, differing)
}

#[test]
fn lavapipe_has_the_bits_of_the_cpu() {
    batches::same_bits(evaluate, QUERIES, 200_000);
}

#[test]
fn validation_is_silent() {
    batches::silent(evaluate, 7, 10_000);
}

#[test]
fn every_other_device_is_within_the_tolerances() {
    batches::within_tolerances(evaluate, QUERIES, 200_000);
}
