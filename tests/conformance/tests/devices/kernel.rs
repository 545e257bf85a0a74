//! Kernels on real devices: lavapipe has the CPU's bits, others are within the tolerances.

use crate::devices::gpu::fails;
use crate::devices::lavapipe::{same_bits, silent, sum, whole_and_cut, within_tolerances};
use crate::devices::software::{Fault, Software};
use conformance::backend::Failure;
use conformance::gpu::Gpu;
use conformance::kernels::{KernelSubject, QUERIES, files, kernels};
use conformance::stages::kernel::body;
use sinew_gpu::headless::Device;
use sinew_gpu::layout::{Resource, Stage};

/// Runs every kernel; returns the number of values compared, and of those that differ.
fn evaluate(device: &dyn Device, query_len: usize) -> (usize, usize) {
    sum(kernels(query_len).iter().map(|subject| {
        let blob = subject.model.blob().len().next_multiple_of(4) as u64;
        // Chunks of few queries.
        let bytes = blob.max(6 << 10);
        whole_and_cut(device, bytes, &subject.described(), |gpu| body(gpu, subject))
    }))
}

#[test]
fn a_device_that_is_wrong_about_a_kernel_is_caught() {
    for bytes in files() {
        let subject = KernelSubject::new(bytes, 14);
        let run = |fault| body(&Gpu::new(&Software::new(bytes, fault)), &subject);
        assert!(!fails(run(None)), "{}", subject.described());
        assert!(fails(run(Some(Fault::Bit(Stage::Kernel, Resource::Out, 5)))), "one bit");
        assert!(fails(run(Some(Fault::Idle(Stage::Kernel)))), "left alone");
        // A query; before the first output; and behind the first confidence.
        let behind = 7 + subject.kernel.result_len();
        for (resource, float) in
            [(Resource::Queries, 7), (Resource::Out, 4), (Resource::Out, behind)]
        {
            let touched = run(Some(Fault::Stray(Stage::Kernel, resource, float)));
            assert!(matches!(touched, Err(Failure::Touched { .. })), "{touched:?}");
        }
    }
}

#[test]
fn lavapipe_has_the_bits_of_the_cpu() {
    same_bits(evaluate, QUERIES, 200_000);
}

#[test]
fn validation_is_silent() {
    silent(evaluate, 7, 10_000);
}

#[test]
fn every_other_device_is_within_the_tolerances() {
    within_tolerances(evaluate, QUERIES, 200_000);
}
