//! Kernels on raw Vulkan, against the CPU's bits and under validation.

use crate::common::kernels;
use crate::{assert_silent, lavapipe, swiftshader};
use sinew_gpu::vulkan::headless::Device;

/// Runs a body on lavapipe and, where it is here, on SwiftShader.
fn on_each(body: impl Fn(&Device)) {
    for device in [Some(lavapipe()), swiftshader()].into_iter().flatten() {
        body(&device);
        assert_silent(&device);
    }
}

#[test]
fn every_kernel_and_rule_has_the_cpus_bits() {
    // SwiftShader flushes what is subnormal, as sums of very distant centres are.
    let device = lavapipe();
    kernels::every_kernel_has_the_cpus_bits(&device);
    assert_silent(&device);
}

#[test]
fn odd_offsets_chunks_and_fewer_queries_have_the_same_bits() {
    on_each(|device| kernels::odd_queries_have_the_cpus_bits(device));
}

#[test]
fn past_65535_queries_nothing_else_is_written() {
    on_each(|device| kernels::past_65535_queries(device));
}

#[test]
fn what_a_cpu_refuses_is_marked() {
    on_each(|device| kernels::a_query_that_is_wrong_is_seen(device));
}
