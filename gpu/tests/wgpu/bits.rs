//! The stages on wgpu, end to end, compared with the CPU's bits.

use crate::common::{self, Case, GOLDEN, goldens, kernels, load, odd_batch, parts};
use crate::wgpu::lavapipe;
use sinew_gpu::headless::{Device as _, HeadlessError};
use sinew_gpu::layout::{Batch, DeviceLimits, LayoutError, Plan, Resource, Stage};
use sinew_gpu::wgpu::headless::Device;
use std::process::Command;

#[test]
fn lavapipe_has_the_cpus_bits() {
    common::every_batch(&lavapipe());
}

#[test]
fn a_batch_in_chunks_has_the_same_bits() {
    let device = lavapipe();
    for bytes in goldens() {
        let model = load(bytes);
        let (envelope, skin) = parts(&model);
        let instances = 60;
        let batch = &odd_batch(&envelope, &skin, instances);
        // The smallest binding that the model allows.
        let storage_binding_bytes = model.blob().len().next_multiple_of(4) as u64;
        let limits = &DeviceLimits { storage_binding_bytes, ..device.limits() };
        let plan = Plan::new(&model, &envelope, batch, limits).unwrap();
        assert!(plan.chunks().len() > 2, "{} chunks", plan.chunks().len());
        let seam = plan.chunks()[1].instances.end;
        for instance_len in [1, seam - 1, seam, seam + 1, instances] {
            Case { bytes, batch, limits, instance_len }.check(&device);
        }
    }
}

#[test]
fn past_65535_workgroups_nothing_else_is_written() {
    let device = lavapipe();
    for bytes in goldens() {
        common::past_65535_workgroups(&device, bytes);
    }
}

#[test]
fn a_changed_pose_is_counted() {
    let device = lavapipe();
    for bytes in goldens() {
        let model = load(bytes);
        let (envelope, skin) = parts(&model);
        let batch = &Batch::skinned(&envelope, &skin, 3);
        let case = Case { bytes, batch, limits: &device.limits(), instance_len: 3 };
        assert_eq!(case.differing(&device, |_| {}).0, 0);
        // The third instance's last joint.
        let change = |poses: &mut [f32]| poses[3 * 12 * envelope.joint_len() - 1] += 1e-4;
        assert_ne!(case.differing(&device, change).0, 0);
    }
}

#[test]
fn a_lost_device_is_reported() {
    let device = lavapipe();
    let model = load(GOLDEN[1]);
    let (envelope, skin) = parts(&model);
    let batch = Batch::skinned(&envelope, &skin, 2);
    let plan = Plan::new(&model, &envelope, &batch, &device.limits()).unwrap();
    let mut uploaded = device.upload(model.blob(), &plan).unwrap();
    uploaded.run(2).unwrap();
    device.device().destroy();
    let lost = |result: Result<(), HeadlessError>| matches!(result, Err(HeadlessError::Lost(_)));
    assert!(lost(uploaded.run(2)));
    assert!(lost(uploaded.run_stage(Stage::Skin, 2)));
    assert!(lost(uploaded.write(Resource::Poses, 0, &[0.0])));
    assert!(lost(uploaded.read(Resource::Out).map(drop)));
    assert!(lost(device.upload(model.blob(), &plan).map(drop)));
}

#[test]
fn a_missing_device_is_reported_with_the_drivers_found() {
    let Err(HeadlessError::NoDevice { api: "wgpu", wanted, found }) =
        Device::of_driver("no such driver", false)
    else {
        panic!("a device was found");
    };
    assert_eq!(wanted, "no such driver");
    assert!(found.contains(&"llvmpipe".to_owned()), "{found:?}");
}

#[test]
fn writing_past_a_buffer_or_to_none_is_refused() {
    let device = lavapipe();
    let model = load(GOLDEN[0]);
    let (envelope, _) = parts(&model);
    let batch = Batch::palettes(&envelope, 2);
    let plan = Plan::new(&model, &envelope, &batch, &device.limits()).unwrap();
    let mut uploaded = device.upload(model.blob(), &plan).unwrap();
    let floats = plan.bytes(Resource::Poses) as usize / 4;
    uploaded.write(Resource::Poses, floats - 1, &[0.0]).unwrap();
    assert!(matches!(
        uploaded.write(Resource::Poses, floats, &[0.0]),
        Err(HeadlessError::Layout(LayoutError::TooShort { resource: Resource::Poses, .. }))
    ));
    assert!(matches!(
        uploaded.read(Resource::Out),
        Err(HeadlessError::Layout(LayoutError::Missing { resource: Resource::Out }))
    ));
}

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
fn a_refused_query_has_confidence_nan() {
    kernels::a_query_that_is_wrong_is_seen(&lavapipe());
}

/// Lines of a host program that a reader takes in at once.
const LINES: usize = 95;

#[test]
fn the_host_program_has_the_cpus_bits() {
    let source =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/wgpu_headless.rs"));
    let lines = source.unwrap().lines().count();
    assert!(lines <= LINES, "{lines} lines");
    // Cargo builds the examples with the tests.
    let own = std::env::current_exe().unwrap();
    let program = own.ancestors().nth(2).unwrap().join("examples/wgpu_headless");
    let model = models::golden_path(models::GOLDEN_NAMES[1]);
    let done = Command::new(&program).arg(model).arg("llvmpipe").output();
    let done = done
        .unwrap_or_else(|error| panic!("{}: {error}; build it with --examples", program.display()));
    let out = String::from_utf8(done.stdout).unwrap();
    let err = String::from_utf8_lossy(&done.stderr);
    assert!(out.contains("\n0 floats differ from the CPU's\n"), "{out}{err}");
    assert_eq!(out.lines().count(), 5, "{out}");
}
