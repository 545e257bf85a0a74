//! Each mistake has its error, found before anything is written or recorded.

use crate::common::{
    GOLDEN, GOLDEN_STRETCH, filter_plan, hosted_batch, kernel_plan, load, parts, remapped_batch,
    shapes_plan,
};
use crate::vulkan::fake;
use ash::vk::{self, Handle};
use sinew_gpu::headless::HeadlessError;
use sinew_gpu::layout::{Batch, Chunk, DeviceLimits, LayoutError, Plan, Resource, Stage};
use sinew_gpu::vulkan::headless::Device;
use sinew_gpu::vulkan::{Bound, Buffers, Error, Pipelines, limits, pool_sizes, set_len, usage};
use sinew_runtime::{Envelope, Skin};
use std::process::Command;

const INSTANCES: usize = 3;

/// Returns a plan of several chunks.
fn chunked() -> Plan {
    let model = load(GOLDEN[0]);
    let (envelope, skin) = parts(&model);
    let limits = DeviceLimits { storage_binding_bytes: 12 << 10, ..DeviceLimits::DOWNLEVEL };
    let batch = Batch::skinned(&envelope, &skin, 100);
    let plan = Plan::new(&model, &envelope, &batch, &limits).unwrap();
    assert!(plan.chunks().len() > 1);
    plan
}

fn plan() -> Plan {
    planned(GOLDEN[0], Batch::skinned)
}

fn planned(bytes: &[u8], batch: impl Fn(&Envelope<'_>, &Skin<'_>, usize) -> Batch) -> Plan {
    let model = load(bytes);
    let (envelope, skin) = parts(&model);
    let batch = batch(&envelope, &skin, INSTANCES);
    Plan::new(&model, &envelope, &batch, &DeviceLimits::DOWNLEVEL).unwrap()
}

/// Plans of every kind of batch; together they need every resource.
fn plans() -> [Plan; 4] {
    let of = |plan: fn(&DeviceLimits) -> (Plan, Vec<u8>)| plan(&DeviceLimits::DOWNLEVEL).0;
    let envelope = planned(GOLDEN_STRETCH[1], remapped_batch);
    let plans = [envelope, of(kernel_plan), of(shapes_plan), of(filter_plan)];
    assert!(Resource::ALL.into_iter().all(|own| plans.iter().any(|plan| plan.bytes(own) > 0)));
    plans
}

fn needed(plan: &Plan) -> impl Iterator<Item = Resource> {
    Resource::ALL.into_iter().filter(|resource| plan.bytes(*resource) > 0)
}

/// Gives every resource its own buffer of the least length.
fn buffers(plan: &Plan) -> Buffers {
    needed(plan).fold(Buffers::default(), |buffers, resource| {
        buffers.with(resource, buffer(resource), 512, plan.bytes(resource))
    })
}

fn buffer(resource: Resource) -> vk::Buffer {
    vk::Buffer::from_raw(100 + resource as u64)
}

fn bind(
    plan: &Plan,
    stages: &[Stage],
    buffers: &Buffers,
    set_len: usize,
) -> (ash::Device, Result<Bound, Error>) {
    let device = fake::device(None);
    let sets = vec![vk::DescriptorSet::from_raw(8); set_len];
    // SAFETY: the fake device only counts.
    let bound = unsafe {
        let pipelines = Pipelines::new(&device, stages, vk::PipelineCache::null(), None).unwrap();
        Bound::new(&device, &pipelines, plan, buffers, &sets)
    };
    (device, bound)
}

#[test]
fn wrong_buffers_are_refused_and_nothing_is_written() {
    plans().iter().for_each(wrong_buffers);
}

fn wrong_buffers(plan: &Plan) {
    let (all, set_len) = (buffers(plan), set_len(plan) as usize);
    let mut cases = vec![
        (Buffers::default(), LayoutError::Missing { resource: Resource::Params }),
        (
            all.with(Resource::Blob, vk::Buffer::null(), 0, 1 << 20),
            LayoutError::Missing { resource: Resource::Blob },
        ),
    ];
    for resource in needed(plan) {
        let least = plan.bytes(resource);
        cases.push((
            all.with(resource, buffer(resource), 0, least - 1),
            LayoutError::TooShort { resource, least, found: least - 1 },
        ));
        cases.push((
            all.with(resource, buffer(resource), 128, least),
            LayoutError::Misaligned { resource, found: 128 },
        ));
    }
    for (buffers, expected) in cases {
        let error = bind(plan, &Stage::ALL, &buffers, set_len).1.unwrap_err();
        assert_eq!(error, Error::Layout(expected));
        assert!(fake::seen().recorded.is_empty());
    }
    bind(plan, &Stage::ALL, &all, set_len).1.unwrap();
    assert!(!fake::seen().recorded.is_empty());
}

#[test]
fn wrong_sets_and_missing_pipelines_are_refused() {
    let plan = plan();
    let (all, expected) = (buffers(&plan), set_len(&plan) as usize);
    for found in [0, expected - 1, expected + 1] {
        let error = bind(&plan, &Stage::ALL, &all, found).1.unwrap_err();
        assert_eq!(error, Error::Sets { expected, found });
    }
    let stages = [Stage::Gradients, Stage::Palette, Stage::Confidence];
    let error = bind(&plan, &stages, &all, expected).1.unwrap_err();
    assert_eq!(error, Error::NoPipeline { stage: Stage::Skin });
    assert!(fake::seen().recorded.is_empty());
}

#[test]
fn a_wrong_number_of_instances_records_nothing() {
    let plan = plan();
    let (device, bound) = bind(&plan, &Stage::ALL, &buffers(&plan), set_len(&plan) as usize);
    let bound = bound.unwrap();
    let written = fake::seen().recorded;
    let commands = vk::CommandBuffer::from_raw(9);
    let many = LayoutError::TooManyInstances { expected: INSTANCES, found: INSTANCES + 1 };
    for (found, expected) in [(0, LayoutError::NoInstances), (INSTANCES + 1, many)] {
        // SAFETY: the fake device only counts.
        let results = unsafe {
            [
                bound.record(&device, commands, found),
                bound.record_stage(&device, commands, Stage::Skin, found),
            ]
        };
        assert_eq!(results, [Err(Error::Layout(expected)); 2]);
    }
    // SAFETY: as above.
    let result = unsafe { bound.record_stage(&device, commands, Stage::Joints, 1) };
    assert_eq!(result, Err(Error::NotPlanned { stage: Stage::Joints }));
    assert_eq!(fake::seen().recorded, written);
}

#[test]
fn resources_overlap_where_both_are_only_read() {
    plans().iter().for_each(overlapping);
}

fn overlapping(plan: &Plan) {
    let all = buffers(plan);
    let set_len = set_len(plan) as usize;
    let written = [Resource::Scratch, Resource::Palettes, Resource::Confidences, Resource::Out];
    for first in needed(plan) {
        for second in needed(plan).filter(|second| first < *second) {
            // Side by side in one buffer; then overlapping by one alignment.
            let end = 512 + plan.bytes(first).next_multiple_of(256);
            let at = |offset| all.with(second, buffer(first), offset, plan.bytes(second));
            bind(plan, &Stage::ALL, &at(end), set_len).1.unwrap();
            let found = bind(plan, &Stage::ALL, &at(end - 256), set_len).1;
            if written.contains(&first) || written.contains(&second) {
                let overlap = LayoutError::Overlap { first, second };
                assert_eq!(found.unwrap_err(), Error::Layout(overlap));
                assert!(fake::seen().recorded.is_empty());
            } else {
                found.unwrap();
            }
        }
    }
}

/// Records a plan's first `instance_len` instances; returns the commands.
fn recorded(plan: &Plan, instance_len: usize) -> Vec<&'static str> {
    let (device, bound) = bind(plan, &Stage::ALL, &buffers(plan), set_len(plan) as usize);
    let written = fake::seen().recorded.len();
    // SAFETY: the fake device only counts.
    unsafe { bound.unwrap().record(&device, vk::CommandBuffer::from_raw(9), instance_len) }
        .unwrap();
    fake::seen().recorded.split_off(written)
}

#[test]
fn barriers_stand_only_before_stages_that_read_earlier_writes() {
    let positions = |envelope: &Envelope<'_>, skin: &Skin<'_>, instance_len| {
        let mut batch = Batch::skinned(envelope, skin, instance_len);
        let own = batch.skin.as_mut().unwrap();
        (own.normals, own.tangents) = (None, None);
        batch
    };
    type Of = fn(&Envelope<'_>, &Skin<'_>, usize) -> Batch;
    // Gradients; palette; skin and, without a barrier, confidence.
    let rotational = vec![true, true, true, false];
    // Joints and features; correction, which changes palettes; skin and confidence.
    let kernel = vec![true, false, true, true, false];
    // Polar comes first; gradients or features read its results.
    let stretching =
        [vec![true, true, true, true, false], vec![true, false, true, true, true, false]];
    let stretching = GOLDEN_STRETCH.into_iter().zip(stretching);
    let all = GOLDEN.into_iter().zip([rotational, kernel]).chain(stretching);
    for (bytes, guarded) in all {
        for batch in [Batch::skinned as Of, hosted_batch as Of, positions as Of] {
            let plan = planned(bytes, batch);
            let stages: Vec<_> = plan.stages().collect();
            assert!(stages.ends_with(&[Stage::Skin, Stage::Confidence]));
            let mut expected = Vec::new();
            for guarded in &guarded {
                expected.extend(guarded.then_some("barrier"));
                expected.extend(["bind pipeline", "bind set", "dispatch"]);
            }
            assert_eq!(recorded(&plan, 1), expected);
        }
    }
}

#[test]
fn chunks_whose_bindings_overlap_have_barriers_between_them() {
    let plan = chunked();
    let span = |chunk, resource| Chunk::span(chunk, resource).unwrap();
    let meet = |resource| {
        let mut pairs = plan.chunks().windows(2);
        pairs.any(|two| {
            let (a, b) = (span(&two[0], resource), span(&two[1], resource));
            a.offset + a.bytes > b.offset
        })
    };
    let mut expected = Vec::new();
    // Gradients; palette; skin, whose chunks end at aligned offsets; confidence without a barrier.
    let steps = [
        (true, Resource::Scratch, true),
        (true, Resource::Palettes, true),
        (true, Resource::Out, false),
        (false, Resource::Confidences, true),
    ];
    for (guarded, written, meets) in steps {
        assert_eq!(meet(written), meets, "{written:?}");
        expected.extend(guarded.then_some("barrier"));
        expected.push("bind pipeline");
        for chunk in 0..plan.chunks().len() {
            expected.extend((meets && chunk > 0).then_some("barrier"));
            expected.extend(["bind set", "dispatch"]);
        }
    }
    assert_eq!(recorded(&plan, 100), expected);
}

#[test]
fn requirements_are_those_of_the_plan() {
    let plan = plan();
    // Gradients, palette, skin, confidence.
    let [uniform, storage] = pool_sizes(&plan).map(|size| size.descriptor_count);
    assert_eq!((set_len(&plan), uniform, storage), (4, 4, 3 + 4 + 4 + 4));
    let plan = chunked();
    let chunks = plan.chunks().len() as u32;
    let [uniform, storage] = pool_sizes(&plan).map(|size| size.descriptor_count);
    assert_eq!((set_len(&plan), uniform, storage), (4 * chunks, 4 * chunks, 15 * chunks));
    // Flags implement `Debug` only with a feature of ash.
    assert!(usage(Resource::Params) == vk::BufferUsageFlags::UNIFORM_BUFFER);
    assert!(usage(Resource::Scratch) == vk::BufferUsageFlags::STORAGE_BUFFER);
}

#[test]
fn a_device_whose_limits_are_too_small_is_refused() {
    let enough = vk::PhysicalDeviceLimits {
        max_storage_buffer_range: 128 << 20,
        max_per_stage_descriptor_storage_buffers: 4,
        max_compute_work_group_count: [65_535; 3],
        max_compute_work_group_invocations: 256,
        max_compute_work_group_size: [256, 256, 64],
        min_storage_buffer_offset_alignment: 256,
        min_uniform_buffer_offset_alignment: 256,
        ..Default::default()
    };
    assert_eq!(limits(&enough), DeviceLimits::DOWNLEVEL);
    let model = load(GOLDEN[0]);
    let (envelope, skin) = parts(&model);
    let batch = Batch::skinned(&envelope, &skin, INSTANCES);
    let plan = |limits: vk::PhysicalDeviceLimits| {
        Plan::new(&model, &envelope, &batch, &self::limits(&limits)).map(|_| ())
    };
    plan(enough).unwrap();
    let device = |found, least| {
        let of = |error| match error {
            LayoutError::Device { found, least, .. } => (found, least),
            _ => panic!("{error:?}"),
        };
        move |result: Result<(), LayoutError>| {
            assert_eq!(result.map_err(of), Err((found, least)));
        }
    };
    device(3, 4)(plan(vk::PhysicalDeviceLimits {
        max_per_stage_descriptor_storage_buffers: 3,
        ..enough
    }));
    device(32, 64)(plan(vk::PhysicalDeviceLimits {
        max_compute_work_group_size: [32, 256, 64],
        ..enough
    }));
    device(1000, 65_535)(plan(vk::PhysicalDeviceLimits {
        max_compute_work_group_count: [65_535, 1000, 1],
        ..enough
    }));
    let aligned = vk::PhysicalDeviceLimits { min_uniform_buffer_offset_alignment: 512, ..enough };
    assert_eq!(plan(aligned), Err(LayoutError::OffsetAlignment { limit: 256, found: 512 }));
    let short = vk::PhysicalDeviceLimits { max_storage_buffer_range: 1 << 10, ..enough };
    assert!(matches!(plan(short), Err(LayoutError::Binding { limit: 1024, .. })));
}

#[test]
fn device_loss_is_a_separate_error() {
    let error = |result| HeadlessError::from(Error::Vulkan { doing: "submitting", result });
    assert_eq!(error(vk::Result::ERROR_DEVICE_LOST), HeadlessError::Lost("submitting".to_owned()));
    let refused = error(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY);
    assert!(matches!(refused, HeadlessError::Refused { doing: "submitting", .. }), "{refused:?}");
}

#[test]
fn an_unknown_driver_is_reported_with_the_drivers_found() {
    let error = Device::of_driver("no such driver", false).err().unwrap();
    let HeadlessError::NoDevice { api: "vulkan", found, .. } = &error else { panic!("{error:?}") };
    assert!(found.iter().any(|driver| driver == "llvmpipe"), "{error}");
}

#[test]
fn a_missing_layer_and_a_missing_driver_say_what_to_install() {
    // The loader reads these variables once in a process, so the test runs itself again for each.
    const CHILD: &str = "SINEW_TEST_CHILD";
    let missing =
        |validation| match Device::open(|_| true, "of any kind", validation).err().unwrap() {
            error @ HeadlessError::Missing { .. } => error.to_string(),
            error => panic!("{error:?}"),
        };
    match std::env::var(CHILD).as_deref() {
        Ok("layer") => assert!(missing(true).contains("vulkan-validationlayers")),
        Ok(_) => assert!(missing(false).contains("mesa-vulkan-drivers")),
        Err(_) => {
            let name = "vulkan::refusals::a_missing_layer_and_a_missing_driver_say_what_to_install";
            for (child, variable) in [("layer", "VK_LAYER_PATH"), ("driver", "VK_DRIVER_FILES")] {
                let output = Command::new(std::env::current_exe().unwrap())
                    .args(["--exact", name])
                    .env(CHILD, child)
                    .env(variable, "no-such-place")
                    .env_remove("VK_ADD_DRIVER_FILES")
                    .output()
                    .unwrap();
                let text = String::from_utf8_lossy(&output.stdout);
                assert!(output.status.success() && text.contains("1 passed"), "{child}: {text}");
            }
        }
    }
}
