//! What comes out has the CPU's bits, and what is not to be written stays as it was.

use crate::common::{Expected, GOLDEN, load, odd_batch, poses};
use crate::{assert_silent, lavapipe, swiftshader};
use sinew_gpu::headless::{Device as _, Uploaded};
use sinew_gpu::layout::{Batch, DeviceLimits, Plan, Resource, Stage};
use sinew_gpu::vulkan::headless::Device;
use sinew_runtime::{Envelope, Matrix3x4};
use std::time::Duration;

/// A NaN that no stage makes.
const POISON: f32 = f32::from_bits(0x7fc0_dead);
const OUT: [Resource; 4] =
    [Resource::Palettes, Resource::Confidences, Resource::OutA, Resource::OutB];

#[test]
fn lavapipe_has_the_cpus_bits() {
    every_batch(&lavapipe());
}

#[test]
fn swiftshader_has_the_cpus_bits() {
    if let Some(device) = swiftshader() {
        every_batch(&device);
    }
}

#[test]
fn a_batch_cut_into_chunks_has_the_same_bits() {
    let device = lavapipe();
    for bytes in GOLDEN {
        let (_, envelope) = load(bytes);
        let limits = DeviceLimits { storage_binding_bytes: 12 << 10, ..device.limits() };
        for instance_len in [64, 41] {
            let chunks = evaluate(&device, bytes, &odd_batch(&envelope, 64), &limits, instance_len);
            assert!(chunks > 3, "{chunks} chunks");
        }
    }
    assert_silent(&device);
}

#[test]
fn a_dispatch_past_one_dimension_has_the_same_bits() {
    const INSTANCES: usize = 65_535 + 130;
    let device = lavapipe();
    let (model, envelope) = load(GOLDEN[0]);
    let batch = Batch::palettes(&envelope, INSTANCES);
    let plan = Plan::new(&model, &envelope, &batch, &device.limits()).unwrap();
    let [chunk] = plan.chunks() else { panic!("more than a chunk") };
    let groups = plan.groups(Stage::Gradients, chunk, INSTANCES).unwrap();
    assert_eq!(groups[1], 2);
    let mut uploaded = device.upload(&model, &plan).unwrap();
    // A prime number of poses in turn: an instance that is taken for another shows.
    let poses: Vec<_> = poses(&envelope, 31).into_iter().cycle().take(INSTANCES).collect();
    uploaded.write(Resource::Poses, 0, &poses.concat().concat().concat()).unwrap();
    uploaded.write(Resource::Palettes, 0, &poison(&plan, Resource::Palettes)).unwrap();
    uploaded.run(INSTANCES).unwrap();
    let mut expected = Expected {
        palettes: poison(&plan, Resource::Palettes),
        confidences: poison(&plan, Resource::Confidences),
        out_a: Vec::new(),
        out_b: Vec::new(),
    };
    expected.evaluate(&envelope, &batch, &poses);
    let found = [Resource::Palettes, Resource::Confidences].map(|own| uploaded.read(own).unwrap());
    same(&found[0], &expected.palettes, "palettes");
    same(&found[1], &expected.confidences, "confidences");
    assert_silent(&device);
}

#[test]
fn what_is_timed_is_run_and_well_guarded() {
    let device = lavapipe();
    let (model, envelope) = load(GOLDEN[2]);
    let batch = Batch::skinned(&envelope, 2);
    let plan = Plan::new(&model, &envelope, &batch, &device.limits()).unwrap();
    let mut uploaded = device.upload(&model, &plan).unwrap();
    uploaded.write(Resource::OutA, 0, &poison(&plan, Resource::OutA)).unwrap();
    for stage in plan.stages() {
        assert!(uploaded.time_stage(stage, 2, 3).unwrap() > Duration::ZERO);
    }
    assert!(uploaded.read(Resource::OutA).unwrap().iter().all(|float| float.is_finite()));
    assert!(device.time_copy(1 << 20, 3).unwrap() > Duration::ZERO);
    assert_silent(&device);
}

#[test]
fn a_stage_alone_reads_what_the_host_wrote() {
    let device = lavapipe();
    let (model, envelope) = load(GOLDEN[0]);
    let batch = Batch::skinned(&envelope, 2);
    let plan = Plan::new(&model, &envelope, &batch, &device.limits()).unwrap();
    let mut uploaded = device.upload(&model, &plan).unwrap();
    let moved = [[[1.0, 0.0, 0.0, 2.5], [0.0, 1.0, 0.0, -1.0], [0.0, 0.0, 1.0, 0.5]]];
    let palette = moved.repeat(envelope.palette_len() * 2);
    uploaded.write(Resource::Palettes, 0, palette.as_flattened().as_flattened()).unwrap();
    uploaded.run_stage(Stage::Skin, 2).unwrap();
    let found = uploaded.read(Resource::OutA).unwrap();
    let mut expected = vec![[0.0; 3]; envelope.vertex_len()];
    envelope.skin_positions(&palette[..envelope.palette_len()], &mut expected).unwrap();
    let expected = expected.as_flattened().repeat(2);
    same(&found, &expected, "positions");
    assert_silent(&device);
}

/// Evaluates each golden: nothing odd, everything odd, palettes only, one instance, some of many.
fn every_batch(device: &Device) {
    println!("on {:?}", device.info());
    for bytes in GOLDEN {
        let (_, envelope) = load(bytes);
        let limits = device.limits();
        let runs = [
            (Batch::skinned(&envelope, 1), 1),
            (Batch::skinned(&envelope, 17), 17),
            (Batch::palettes(&envelope, 5), 5),
            (odd_batch(&envelope, 3), 3),
            (odd_batch(&envelope, 129), 129),
            (odd_batch(&envelope, 129), 7),
            (Batch { confidences: None, ..odd_batch(&envelope, 4) }, 4),
        ];
        for (batch, instance_len) in runs {
            evaluate(device, bytes, &batch, &limits, instance_len);
        }
    }
    assert_silent(device);
}

/// Evaluates poisoned buffers and compares every float of them; returns the number of chunks.
fn evaluate(
    device: &Device,
    bytes: &[u8],
    batch: &Batch,
    limits: &DeviceLimits,
    instance_len: usize,
) -> usize {
    let (model, envelope) = load(bytes);
    let plan = Plan::new(&model, &envelope, batch, limits).unwrap();
    let mut uploaded = device.upload(&model, &plan).unwrap();
    let poison = |resource| poison(&plan, resource);
    for resource in OUT.into_iter().chain([Resource::Work]) {
        if plan.bytes(resource) > 0 {
            uploaded.write(resource, 0, &poison(resource)).unwrap();
        }
    }
    let poses = poses(&envelope, instance_len);
    write_poses(&mut *uploaded, &envelope, batch, &poses);
    uploaded.run(instance_len).unwrap();

    let mut expected = Expected {
        palettes: poison(Resource::Palettes),
        confidences: poison(Resource::Confidences),
        out_a: poison(Resource::OutA),
        out_b: poison(Resource::OutB),
    };
    expected.evaluate(&envelope, batch, &poses);
    let Expected { palettes, confidences, out_a, out_b } = expected;
    for (resource, expected) in OUT.into_iter().zip([palettes, confidences, out_a, out_b]) {
        if plan.bytes(resource) == 0 {
            continue;
        }
        let found = uploaded.read(resource).unwrap();
        // The rest of the last workgroup's threads reaches at most 63 instances further.
        let [ours, spilt] =
            [instance_len, instance_len + 63].map(|n| floats_before(resource, batch, n));
        let (ours, spilt) = (ours.min(found.len()), spilt.min(found.len()));
        same(&found[..ours], &expected[..ours], resource.name());
        same_or_empty(&found[spilt..], &expected[spilt..], resource.name());
    }
    plan.chunks().len()
}

fn poison(plan: &Plan, resource: Resource) -> Vec<f32> {
    vec![POISON; plan.bytes(resource) as usize / 4]
}

fn write_poses(
    uploaded: &mut dyn Uploaded,
    envelope: &Envelope<'_>,
    batch: &Batch,
    poses: &[Vec<Matrix3x4>],
) {
    assert!(poses.iter().all(|pose| pose.len() == envelope.joint_len()));
    for (n, pose) in poses.iter().enumerate() {
        let first = batch.poses.offset + n * batch.poses.stride;
        uploaded.write(Resource::Poses, first, pose.as_flattened().as_flattened()).unwrap();
    }
}

/// Returns where in a resource instance n starts; the end if there is no such instance.
fn floats_before(resource: Resource, batch: &Batch, n: usize) -> usize {
    if n >= batch.instance_len {
        return usize::MAX;
    }
    let attributes = || {
        let skin = batch.skin.iter();
        skin.flat_map(|skin| [skin.positions, skin.normals, skin.tangents]).flatten()
    };
    let of = |buffer| {
        let own = attributes().filter(|own| own.buffer == buffer);
        own.map(|own| own.offset + n * own.instance_stride).min().unwrap()
    };
    match resource {
        Resource::Palettes => batch.palettes.offset + n * batch.palettes.stride,
        Resource::Confidences => {
            batch.confidences.map_or(0, |array| array.offset + n * array.stride)
        }
        Resource::OutA => of(sinew_gpu::layout::Buffer::A),
        _ => of(sinew_gpu::layout::Buffer::B),
    }
}

fn same(found: &[f32], expected: &[f32], what: &str) {
    assert!(!expected.is_empty());
    same_or_empty(found, expected, what);
}

/// Compares bits: poison must be poison, and nothing else is.
fn same_or_empty(found: &[f32], expected: &[f32], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!(
            found.to_bits() == expected.to_bits(),
            "{what} {i}: {found:e} ({:#x}), expected {expected:e} ({:#x})",
            found.to_bits(),
            expected.to_bits()
        );
    }
}

#[test]
#[should_panic(expected = "there 1")]
fn the_comparison_sees_one_bit() {
    same(&[1.0, 2.0], &[1.0, 2.0_f32.next_up()], "there");
}
