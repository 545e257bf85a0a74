//! The stages on wgpu, end to end, against the CPU's bits.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{Expected, GOLDEN, load, odd_batch, poses};
use sinew_gpu::headless::{Device as _, HeadlessError};
use sinew_gpu::layout::{Batch, DeviceLimits, LayoutError, Plan, Resource, Stage};
use sinew_gpu::wgpu::headless::Device;
use sinew_runtime::Matrix3x4;

/// What buffers hold before: a NaN that no stage writes.
const POISON: u32 = 0x7fed_cba9;
const OUTPUTS: [Resource; 4] =
    [Resource::Palettes, Resource::Confidences, Resource::OutA, Resource::OutB];

fn lavapipe() -> Device {
    Device::of_driver("llvmpipe", true)
        .unwrap_or_else(|error| panic!("{error}; install mesa-vulkan-drivers"))
}

/// Runs the first `instance_len` instances of a batch, and counts the bits of its outputs that are
/// not the CPU's; floats that nothing is to be written to among them, but for instances beyond.
fn differing(
    device: &Device,
    bytes: &[u8],
    batch: &Batch,
    limits: &DeviceLimits,
    instance_len: usize,
) -> u32 {
    let (model, envelope) = load(bytes);
    let plan = Plan::new(&model, &envelope, batch, limits).unwrap();
    let poses = poses(&envelope, batch.instance_len);
    let mut uploaded = device.upload(&model, &plan).unwrap();
    uploaded.write(Resource::Poses, 0, &laid_out(&plan, batch, &poses)).unwrap();
    let poisoned = |resource| vec![f32::from_bits(POISON); (plan.bytes(resource) / 4) as usize];
    let present = |resource: &Resource| plan.bytes(*resource) > 0;
    for resource in OUTPUTS.into_iter().chain([Resource::Work]).filter(present) {
        uploaded.write(resource, 0, &poisoned(resource)).unwrap();
    }
    uploaded.run(instance_len).unwrap();
    let mut expected = Expected {
        palettes: poisoned(Resource::Palettes),
        confidences: poisoned(Resource::Confidences),
        out_a: poisoned(Resource::OutA),
        out_b: poisoned(Resource::OutB),
    };
    expected.evaluate(&envelope, batch, &poses[..instance_len]);
    let Expected { palettes, confidences, out_a, out_b } = expected;
    let mut count = 0;
    for (resource, expected) in OUTPUTS.into_iter().zip([palettes, confidences, out_a, out_b]) {
        if present(&resource) {
            let found = uploaded.read(resource).unwrap();
            assert_eq!(found.len(), expected.len());
            let apart = |(a, b): (&f32, &f32)| (a.to_bits() ^ b.to_bits()).count_ones();
            let differ: u32 = found.iter().zip(&expected).map(apart).sum();
            if differ > 0 {
                eprintln!("{}: {differ} bits of {:?}", resource.name(), envelope.predictor());
            }
            count += differ;
        }
    }
    count
}

/// Lays poses out as a batch says.
fn laid_out(plan: &Plan, batch: &Batch, poses: &[Vec<Matrix3x4>]) -> Vec<f32> {
    let mut out = vec![f32::NAN; (plan.bytes(Resource::Poses) / 4) as usize];
    for (n, pose) in poses.iter().enumerate() {
        let flat = pose.as_flattened().as_flattened();
        let at = batch.poses.offset + n * batch.poses.stride;
        out[at..at + flat.len()].copy_from_slice(flat);
    }
    out
}

#[test]
fn every_predictor_has_the_cpus_bits() {
    let device = lavapipe();
    for bytes in GOLDEN {
        let (_, envelope) = load(bytes);
        let batch = Batch::skinned(&envelope, 67);
        assert_eq!(differing(&device, bytes, &batch, &device.limits(), 67), 0);
        let batch = Batch::palettes(&envelope, 5);
        assert_eq!(differing(&device, bytes, &batch, &device.limits(), 5), 0);
    }
}

#[test]
fn odd_offsets_and_strides_are_kept_and_gaps_left_alone() {
    let device = lavapipe();
    for bytes in GOLDEN {
        let (_, envelope) = load(bytes);
        let batch = odd_batch(&envelope, 9);
        assert_eq!(differing(&device, bytes, &batch, &device.limits(), 9), 0);
    }
}

#[test]
fn a_batch_in_chunks_has_the_same_bits() {
    let device = lavapipe();
    for bytes in GOLDEN {
        let (model, envelope) = load(bytes);
        let batch = odd_batch(&envelope, 9);
        let whole = Plan::new(&model, &envelope, &batch, &device.limits()).unwrap();
        let largest = Resource::ALL.into_iter().map(|resource| match resource {
            Resource::Blob | Resource::Params => 0,
            _ => whole.bytes(resource),
        });
        let half = largest.max().unwrap() / 2;
        let storage_binding_bytes = half.max(whole.bytes(Resource::Blob));
        let limits = DeviceLimits { storage_binding_bytes, ..device.limits() };
        let plan = Plan::new(&model, &envelope, &batch, &limits).unwrap();
        eprintln!("{:?}: {} chunks", envelope.predictor(), plan.chunks().len());
        for instance_len in [1, 5, 9] {
            assert_eq!(
                differing(&device, bytes, &batch, &limits, instance_len),
                0,
                "{instance_len} instances"
            );
        }
    }
}

#[test]
fn a_lost_device_is_told() {
    let device = lavapipe();
    let (model, envelope) = load(GOLDEN[2]);
    let batch = Batch::skinned(&envelope, 2);
    let plan = Plan::new(&model, &envelope, &batch, &device.limits()).unwrap();
    let mut uploaded = device.upload(&model, &plan).unwrap();
    uploaded.run(2).unwrap();
    device.device().destroy();
    let lost = |result: Result<(), HeadlessError>| matches!(result, Err(HeadlessError::Lost(_)));
    assert!(lost(uploaded.run(2)));
    assert!(lost(uploaded.run_stage(Stage::Skin, 2)));
    assert!(lost(uploaded.write(Resource::Poses, 0, &[0.0])));
    assert!(lost(uploaded.read(Resource::OutA).map(drop)));
    assert!(lost(device.upload(&model, &plan).map(drop)));
    assert!(lost(device.time_copy(4, 1).map(drop)));
}

#[test]
fn a_device_that_is_not_there_is_told_with_those_that_are() {
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
    let (model, envelope) = load(GOLDEN[0]);
    let batch = Batch::palettes(&envelope, 2);
    let plan = Plan::new(&model, &envelope, &batch, &device.limits()).unwrap();
    let mut uploaded = device.upload(&model, &plan).unwrap();
    let floats = plan.bytes(Resource::Poses) as usize / 4;
    uploaded.write(Resource::Poses, floats - 1, &[0.0]).unwrap();
    assert!(matches!(
        uploaded.write(Resource::Poses, floats, &[0.0]),
        Err(HeadlessError::Layout(LayoutError::TooShort { resource: Resource::Poses, .. }))
    ));
    assert!(matches!(
        uploaded.read(Resource::OutA),
        Err(HeadlessError::Layout(LayoutError::Missing { resource: Resource::OutA }))
    ));
}
