//! The stages on wgpu, end to end, against the CPU's bits.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{Expected, GOLDEN, load, odd_batch, poses};
use sinew_gpu::headless::{Device as _, HeadlessError};
use sinew_gpu::layout::{Array, Batch, DeviceLimits, LayoutError, Plan, Resource, Stage};
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

fn differing(
    device: &Device,
    bytes: &[u8],
    batch: &Batch,
    limits: &DeviceLimits,
    instance_len: usize,
) -> u32 {
    Case { bytes, batch, limits, instance_len }.differing(device, |_| {})
}

/// The first instances of a batch.
struct Case<'a> {
    bytes: &'a [u8],
    batch: &'a Batch,
    limits: &'a DeviceLimits,
    instance_len: usize,
}

impl Case<'_> {
    /// Runs it on poses that have been changed, and counts the bits of its outputs that are not the
    /// CPU's for the poses as they were; floats that nothing is to be written to among them, but not
    /// the later instances', which may be overwritten.
    fn differing(&self, device: &Device, change: impl Fn(&mut [f32])) -> u32 {
        let Self { bytes, batch, limits, instance_len } = *self;
        let (model, envelope) = load(bytes);
        let plan = Plan::new(&model, &envelope, batch, limits).unwrap();
        let poses = poses(&envelope, batch.instance_len);
        let mut uploaded = device.upload(&model, &plan).unwrap();
        let mut flat = laid_out(&plan, batch, &poses);
        change(&mut flat);
        uploaded.write(Resource::Poses, 0, &flat).unwrap();
        let poisoned = |resource| vec![f32::from_bits(POISON); (plan.bytes(resource) / 4) as usize];
        let present = |resource: &Resource| plan.bytes(*resource) > 0;
        for resource in OUTPUTS.into_iter().chain([Resource::Work]).filter(present) {
            uploaded.write(resource, 0, &poisoned(resource)).unwrap();
        }
        uploaded.run(instance_len).unwrap();
        let expected = |poses: &[Vec<Matrix3x4>]| {
            let mut expected = Expected {
                palettes: poisoned(Resource::Palettes),
                confidences: poisoned(Resource::Confidences),
                out_a: poisoned(Resource::OutA),
                out_b: poisoned(Resource::OutB),
            };
            expected.evaluate(&envelope, batch, poses);
            let Expected { palettes, confidences, out_a, out_b } = expected;
            [palettes, confidences, out_a, out_b]
        };
        let (first, all) = (expected(&poses[..instance_len]), expected(&poses));
        let mut count = 0;
        for (resource, (first, all)) in OUTPUTS.into_iter().zip(first.iter().zip(&all)) {
            if !present(&resource) {
                continue;
            }
            let found = uploaded.read(resource).unwrap();
            assert_eq!(found.len(), first.len());
            let mut differ = 0;
            for (found, (first, all)) in found.iter().zip(first.iter().zip(all)) {
                let is_later = first.to_bits() == POISON && all.to_bits() != POISON;
                if !is_later {
                    differ += (found.to_bits() ^ first.to_bits()).count_ones();
                }
            }
            if differ > 0 {
                eprintln!("{}: {differ} bits of {:?}", resource.name(), envelope.predictor());
            }
            count += differ;
        }
        count
    }
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
        let instances = 60;
        let batch = odd_batch(&envelope, instances);
        // As small as the model allows.
        let storage_binding_bytes = model.blob().len().next_multiple_of(4) as u64;
        let limits = DeviceLimits { storage_binding_bytes, ..device.limits() };
        let plan = Plan::new(&model, &envelope, &batch, &limits).unwrap();
        assert!(plan.chunks().len() > 2, "{} chunks", plan.chunks().len());
        let seam = plan.chunks()[1].instances.end;
        for instance_len in [1, seam - 1, seam, seam + 1, instances] {
            let differ = differing(&device, bytes, &batch, &limits, instance_len);
            assert_eq!(differ, 0, "{instance_len} instances");
        }
    }
}

#[test]
fn more_workgroups_than_one_dimension_holds_are_dispatched() {
    let device = lavapipe();
    let instances = 65_535 + 70;
    for bytes in GOLDEN {
        let (model, envelope) = load(bytes);
        let poses_of_all = Array { offset: 0, stride: 0 };
        let batch = Batch { poses: poses_of_all, ..Batch::palettes(&envelope, instances) };
        let plan = Plan::new(&model, &envelope, &batch, &device.limits()).unwrap();
        assert_eq!(plan.chunks().len(), 1);
        let groups = |stage| plan.groups(stage, &plan.chunks()[0], instances).unwrap();
        assert!(plan.stages().any(|stage| groups(stage)[1] > 1));
        let pose = poses(&envelope, 2).remove(1);
        let mut uploaded = device.upload(&model, &plan).unwrap();
        uploaded.write(Resource::Poses, 0, pose.as_flattened().as_flattened()).unwrap();
        uploaded.run(instances).unwrap();
        let mut palette = vec![[[0.0; 4]; 3]; envelope.palette_len()];
        let mut workspace = vec![0.0; envelope.workspace_len()];
        envelope.palette(&pose, &mut workspace, &mut palette).unwrap();
        let expected = palette.as_flattened().as_flattened();
        let found = uploaded.read(Resource::Palettes).unwrap();
        let same =
            |found: &[f32]| found.iter().zip(expected).all(|(a, b)| a.to_bits() == b.to_bits());
        assert!(found.chunks_exact(expected.len()).all(same), "{:?}", envelope.predictor());
    }
}

#[test]
fn the_count_sees_a_nudge() {
    let device = lavapipe();
    for bytes in GOLDEN {
        let (_, envelope) = load(bytes);
        let batch = Batch::skinned(&envelope, 3);
        let case = Case { bytes, batch: &batch, limits: &device.limits(), instance_len: 3 };
        assert_eq!(case.differing(&device, |_| {}), 0);
        // The third instance's last joint.
        let nudge = |poses: &mut [f32]| poses[3 * 12 * envelope.joint_len() - 1] += 1e-4;
        assert_ne!(case.differing(&device, nudge), 0);
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
