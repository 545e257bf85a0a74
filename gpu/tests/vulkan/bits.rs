//! Outputs have the CPU's bits, and no other float changes.

use crate::common::{
    self, Case, GOLDEN, POISON, differing, goldens, hosted_batch, kernels, load, odd_batch, parts,
};
use crate::vulkan::{assert_silent, lavapipe, swiftshader};
use sinew_gpu::headless::Device as _;
use sinew_gpu::layout::{Batch, DeviceLimits, Plan, Resource, Stage};
use sinew_gpu::vulkan::headless::Device;
use std::time::Duration;

#[test]
fn lavapipe_has_the_cpus_bits() {
    let device = lavapipe();
    common::every_batch(&device);
    assert_silent(&device);
}

#[test]
fn swiftshader_has_the_cpus_bits() {
    if let Some(device) = swiftshader() {
        common::every_batch(&device);
        assert_silent(&device);
    }
}

#[test]
fn a_batch_cut_into_chunks_has_the_same_bits() {
    let device = lavapipe();
    for bytes in goldens() {
        let model = load(bytes);
        let (envelope, skin) = parts(&model);
        let limits = &DeviceLimits { storage_binding_bytes: 12 << 10, ..device.limits() };
        for instance_len in [64, 41] {
            let batch = &odd_batch(&envelope, &skin, 64);
            let chunks = Case { bytes, batch, limits, instance_len }.check(&device);
            assert!(chunks > 3, "{chunks} chunks");
        }
        let limits = &DeviceLimits { storage_binding_bytes: 128 << 10, ..device.limits() };
        let batch = &hosted_batch(&envelope, &skin, 64);
        let chunks = Case { bytes, batch, limits, instance_len: 50 }.check(&device);
        assert!(chunks > 1, "{chunks} chunks");
    }
    assert_silent(&device);
}

#[test]
fn past_65535_workgroups_nothing_else_is_written() {
    let device = lavapipe();
    for bytes in goldens() {
        common::past_65535_workgroups(&device, bytes);
    }
    assert_silent(&device);
}

#[test]
fn timing_a_stage_runs_it_with_its_barriers() {
    let device = lavapipe();
    let model = load(GOLDEN[1]);
    let (envelope, skin) = parts(&model);
    let batch = Batch::skinned(&envelope, &skin, 2);
    let plan = Plan::new(&model, &envelope, &batch, &device.limits()).unwrap();
    let mut uploaded = device.upload(model.blob(), &plan).unwrap();
    let poison = vec![POISON; plan.bytes(Resource::Out) as usize / 4];
    uploaded.write(Resource::Out, 0, &poison).unwrap();
    for stage in plan.stages() {
        assert!(uploaded.time_stage(stage, 2, 3).unwrap() > Duration::ZERO);
    }
    assert!(uploaded.read(Resource::Out).unwrap().iter().all(|float| float.is_finite()));
    assert_silent(&device);
}

#[test]
fn a_stage_alone_reads_what_the_host_wrote() {
    let device = lavapipe();
    let model = load(GOLDEN[0]);
    let (envelope, skin) = parts(&model);
    let mut batch = Batch::skinned(&envelope, &skin, 2);
    let own = batch.skin.as_mut().unwrap();
    (own.normals, own.tangents) = (None, None);
    own.positions.as_mut().unwrap().instance_stride = 3 * skin.vertex_len();
    let plan = Plan::new(&model, &envelope, &batch, &device.limits()).unwrap();
    let mut uploaded = device.upload(model.blob(), &plan).unwrap();
    let moved = [[[1.0, 0.0, 0.0, 2.5], [0.0, 1.0, 0.0, -1.0], [0.0, 0.0, 1.0, 0.5]]];
    let palette = moved.repeat(envelope.palette_len() * 2);
    uploaded.write(Resource::Palettes, 0, palette.as_flattened().as_flattened()).unwrap();
    uploaded.run_stage(Stage::Skin, 2).unwrap();
    let found = uploaded.read(Resource::Out).unwrap();
    let mut expected = vec![[0.0; 3]; skin.vertex_len()];
    skin.skin_positions(&palette[..envelope.palette_len()], &mut expected).unwrap();
    let expected = expected.as_flattened().repeat(2);
    assert_eq!(differing(&found, &expected, "positions"), 0);
    assert_silent(&device);
}

#[test]
fn the_comparison_sees_one_bit() {
    assert_eq!(differing(&[1.0, 2.0], &[1.0, 2.0], "there"), 0);
    assert_eq!(differing(&[1.0, 2.0], &[1.0, 2.0_f32.next_up()], "there"), 1);
    let quiet = f32::from_bits(POISON.to_bits() ^ 1);
    assert_eq!(differing(&[POISON, 0.0], &[quiet, -0.0], "there"), 2);
}

#[test]
fn every_kernel_and_rule_has_the_cpus_bits() {
    // Not on SwiftShader, which flushes subnormal numbers; sums over very distant centres are
    // subnormal.
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
fn a_refused_query_has_confidence_nan() {
    on_each(|device| kernels::a_query_that_is_wrong_is_seen(device));
}

/// Runs a body on lavapipe and, if it is installed, on SwiftShader.
fn on_each(body: impl Fn(&Device)) {
    for device in [Some(lavapipe()), swiftshader()].into_iter().flatten() {
        body(&device);
        assert_silent(&device);
    }
}
