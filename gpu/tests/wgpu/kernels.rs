//! Kernels on wgpu, against the CPU's bits.

use crate::bits::lavapipe;
use crate::common::kernels;

#[test]
fn every_kernel_and_rule_has_the_cpus_bits() {
    kernels::every_kernel_has_the_cpus_bits(&lavapipe());
}

#[test]
fn odd_offsets_chunks_and_fewer_queries_have_the_same_bits() {
    kernels::odd_queries_have_the_cpus_bits(&lavapipe());
}

#[test]
fn past_65535_queries_nothing_else_is_written() {
    kernels::past_65535_queries(&lavapipe());
}

#[test]
fn what_a_cpu_refuses_is_marked() {
    kernels::a_query_that_is_wrong_is_seen(&lavapipe());
}
