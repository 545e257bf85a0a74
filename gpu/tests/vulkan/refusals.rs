//! Each mistake has its error, found before anything is written or recorded.

use crate::common::{GOLDEN, load};
use crate::fake;
use ash::vk::{self, Handle};
use sinew_gpu::headless::HeadlessError;
use sinew_gpu::layout::{Batch, DeviceLimits, LayoutError, Plan, Resource, Stage};
use sinew_gpu::vulkan::headless::Device;
use sinew_gpu::vulkan::{Bound, Buffers, Error, Pipelines, limits, pool_sizes, set_len, usage};
use std::process::Command;

const INSTANCES: usize = 3;

/// Returns a plan of several chunks.
fn chunked() -> Plan {
    let (model, envelope) = load(GOLDEN[0]);
    let limits = DeviceLimits { storage_binding_bytes: 12 << 10, ..DeviceLimits::DOWNLEVEL };
    let plan = Plan::new(&model, &envelope, &Batch::skinned(&envelope, 100), &limits).unwrap();
    assert!(plan.chunks().len() > 1);
    plan
}

fn plan() -> Plan {
    let (model, envelope) = load(GOLDEN[0]);
    let batch = Batch::skinned(&envelope, INSTANCES);
    Plan::new(&model, &envelope, &batch, &DeviceLimits::DOWNLEVEL).unwrap()
}

/// Gives every resource a buffer as short as may be.
fn buffers(plan: &Plan) -> Buffers {
    let all = Resource::ALL.into_iter().filter(|resource| plan.bytes(*resource) > 0);
    all.fold(Buffers::default(), |buffers, resource| {
        buffers.with(resource, vk::Buffer::from_raw(7), 512, plan.bytes(resource))
    })
}

fn bind(
    plan: &Plan,
    stages: &[Stage],
    buffers: &Buffers,
    set_len: usize,
) -> (ash::Device, Result<Bound, Error>) {
    let device = fake::device(None);
    let sets = vec![vk::DescriptorSet::from_raw(8); set_len];
    // SAFETY: the device keeps nothing but counts.
    let bound = unsafe {
        let pipelines = Pipelines::new(&device, stages, vk::PipelineCache::null(), None).unwrap();
        Bound::new(&device, &pipelines, plan, buffers, &sets)
    };
    (device, bound)
}

#[test]
fn wrong_buffers_are_refused_and_nothing_is_written() {
    let plan = plan();
    let (all, set_len) = (buffers(&plan), set_len(&plan) as usize);
    let buffer = vk::Buffer::from_raw(7);
    let mut cases = vec![
        (Buffers::default(), LayoutError::Missing { resource: Resource::Params }),
        (
            all.with(Resource::Poses, vk::Buffer::null(), 0, 1 << 20),
            LayoutError::Missing { resource: Resource::Poses },
        ),
    ];
    for resource in Resource::ALL {
        let least = plan.bytes(resource);
        cases.push((
            all.with(resource, buffer, 0, least - 1),
            LayoutError::TooShort { resource, least, found: least - 1 },
        ));
        cases.push((
            all.with(resource, buffer, 128, least),
            LayoutError::Misaligned { resource, found: 128 },
        ));
    }
    for (buffers, expected) in cases {
        let error = bind(&plan, &Stage::ALL, &buffers, set_len).1.unwrap_err();
        assert_eq!(error, Error::Layout(expected));
        assert!(fake::seen().recorded.is_empty());
    }
    bind(&plan, &Stage::ALL, &all, set_len).1.unwrap();
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
        // SAFETY: the device keeps nothing but counts.
        let results = unsafe {
            [
                bound.record(&device, commands, found),
                bound.record_stage(&device, commands, Stage::Skin, found),
            ]
        };
        assert_eq!(results, [Err(Error::Layout(expected)); 2]);
    }
    // SAFETY: likewise.
    let result = unsafe { bound.record_stage(&device, commands, Stage::Joints, 1) };
    assert_eq!(result, Err(Error::NotPlanned { stage: Stage::Joints }));
    assert_eq!(fake::seen().recorded, written);
}

#[test]
fn what_is_recorded_is_as_documented() {
    let plan = plan();
    let (device, bound) = bind(&plan, &Stage::ALL, &buffers(&plan), set_len(&plan) as usize);
    let written = fake::seen().recorded.len();
    // SAFETY: the device keeps nothing but counts.
    unsafe { bound.unwrap().record(&device, vk::CommandBuffer::from_raw(9), 1) }.unwrap();
    let dispatch = ["bind pipeline", "bind set", "dispatch"];
    // Gradients; palette and confidence, which both read what they wrote; skin.
    let mut expected = vec!["barrier"];
    expected.extend(dispatch);
    for guarded in [true, false, true] {
        expected.extend(guarded.then_some("barrier"));
        expected.extend(dispatch);
    }
    assert_eq!(fake::seen().recorded[written..], expected);
}

#[test]
fn chunks_whose_bindings_meet_are_kept_apart() {
    let plan = chunked();
    let (device, bound) = bind(&plan, &Stage::ALL, &buffers(&plan), set_len(&plan) as usize);
    let written = fake::seen().recorded.len();
    // SAFETY: the device keeps nothing but counts.
    unsafe { bound.unwrap().record(&device, vk::CommandBuffer::from_raw(9), 100) }.unwrap();
    let mut expected = Vec::new();
    // Gradients; palette and confidence; skin.
    for guarded in [true, true, false, true] {
        expected.extend(guarded.then_some("barrier"));
        expected.push("bind pipeline");
        for chunk in 0..plan.chunks().len() {
            expected.extend((chunk > 0).then_some("barrier"));
            expected.extend(["bind set", "dispatch"]);
        }
    }
    assert_eq!(fake::seen().recorded[written..], expected);
}

#[test]
fn requirements_are_those_of_the_plan() {
    let plan = plan();
    // Gradients, palette, confidence, skin.
    let [uniform, storage] = pool_sizes(&plan).map(|size| size.descriptor_count);
    assert_eq!((set_len(&plan), uniform, storage), (4, 4, 3 + 4 + 3 + 4));
    let plan = chunked();
    let chunks = plan.chunks().len() as u32;
    let [uniform, storage] = pool_sizes(&plan).map(|size| size.descriptor_count);
    assert_eq!((set_len(&plan), uniform, storage), (4 * chunks, 4 * chunks, 14 * chunks));
    // Flags have no names without a feature of ash.
    assert!(usage(Resource::Params) == vk::BufferUsageFlags::UNIFORM_BUFFER);
    assert!(usage(Resource::Work) == vk::BufferUsageFlags::STORAGE_BUFFER);
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
    let (model, envelope) = load(GOLDEN[0]);
    let batch = Batch::skinned(&envelope, INSTANCES);
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
fn a_lost_device_is_told_from_a_refusal() {
    let error = |result| HeadlessError::from(Error::Vulkan { doing: "submitting", result });
    assert_eq!(error(vk::Result::ERROR_DEVICE_LOST), HeadlessError::Lost("submitting".to_owned()));
    let refused = error(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY);
    assert!(matches!(refused, HeadlessError::Refused { doing: "submitting", .. }), "{refused:?}");
}

#[test]
fn an_unknown_driver_is_answered_with_those_there_are() {
    let error = Device::of_driver("no such driver", false).err().unwrap();
    let HeadlessError::NoDevice { api: "vulkan", found, .. } = &error else { panic!("{error:?}") };
    assert!(found.iter().any(|driver| driver == "llvmpipe"), "{error}");
}

#[test]
fn a_missing_layer_and_a_missing_driver_say_what_to_install() {
    // The loader reads these variables of a process: the test runs itself once more for each.
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
            let name = "refusals::a_missing_layer_and_a_missing_driver_say_what_to_install";
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
