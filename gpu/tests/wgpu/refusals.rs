//! The wgpu backend refuses each mistake before anything is recorded.

use crate::common::{GOLDEN, load, parts};
use crate::wgpu::{COPIED, Scene, buffer, palettes, scene, scenes, whole};
use sinew_gpu::headless::Device as _;
use sinew_gpu::layout::{Array, Batch, DeviceLimits, LayoutError, Plan, Resource, Stage};
use sinew_gpu::wgpu::headless::Device;
use sinew_gpu::wgpu::{Bound, Buffers, Error, Pipelines, limits};
use wgpu::{BufferUsages, ErrorFilter, Limits};

#[test]
fn a_buffer_that_is_missing_short_or_misaligned_is_refused() {
    scenes().iter().for_each(missing_short_and_misaligned);
}

fn missing_short_and_misaligned(scene: &Scene) {
    Bound::new(&scene.pipelines, &scene.plan, &scene.buffers()).unwrap();
    for resource in scene.needed() {
        let others = Resource::ALL.into_iter().filter(|other| *other != resource);
        let missing = others.fold(Buffers::new(), |buffers, other| {
            buffers.with(other, &scene.own[other as usize], 0)
        });
        assert_eq!(scene.refused(&missing), LayoutError::Missing { resource }.into());

        let least = scene.plan.bytes(resource);
        let usage = scene.own[resource as usize].usage();
        let short = scene.make(least - 4, usage);
        let found = least - 4;
        assert_eq!(
            scene.refused(&scene.buffers().with(resource, &short, 0)),
            LayoutError::TooShort { resource, least, found }.into()
        );

        let long = scene.make(least + 512, usage);
        Bound::new(&scene.pipelines, &scene.plan, &scene.buffers().with(resource, &long, 256))
            .unwrap();
        for (offset, expected) in [
            (4, LayoutError::Misaligned { resource, found: 4 }),
            (768, LayoutError::TooShort { resource, least, found: least.saturating_sub(256) }),
        ] {
            assert_eq!(
                scene.refused(&scene.buffers().with(resource, &long, offset)),
                expected.into()
            );
        }
        // Past the end of the address space.
        let beyond = u64::MAX - 255;
        assert_eq!(
            scene.refused(&scene.buffers().with(resource, &long, beyond)),
            LayoutError::TooShort { resource, least, found: 0 }.into()
        );
    }
}

#[test]
fn a_buffer_without_its_usage_is_refused() {
    scenes().iter().for_each(without_usage);
}

fn without_usage(scene: &Scene) {
    for resource in scene.needed() {
        let (expected, other) = match resource {
            Resource::Params => (BufferUsages::UNIFORM, BufferUsages::STORAGE),
            _ => (BufferUsages::STORAGE, BufferUsages::UNIFORM),
        };
        let found = other | COPIED;
        let wrong = scene.make(scene.plan.bytes(resource), found);
        assert_eq!(
            scene.refused(&scene.buffers().with(resource, &wrong, 0)),
            Error::Usage { resource, expected, found }
        );
    }
}

#[test]
fn what_is_not_needed_may_be_left_out_or_wrong() {
    use Resource::{Confidences, Curves, Host, Out, Queries};
    let scene = scene(GOLDEN[1], palettes);
    let wrong = scene.make(4, BufferUsages::VERTEX);
    for resource in [Curves, Queries, Confidences, Host, Out] {
        assert!(!scene.needs(resource));
        let buffers = scene.buffers().with(resource, &wrong, 3);
        let bound = Bound::new(&scene.pipelines, &scene.plan, &buffers).unwrap();
        submit(&scene.device, &bound, 3).unwrap();
    }
}

#[test]
fn one_buffer_may_hold_what_no_stage_both_reads_and_writes() {
    let usage = BufferUsages::STORAGE | BufferUsages::UNIFORM | COPIED;
    // No stage of the kernel predictor reads a resource that it writes, and one stage writes two.
    let scene = scene(GOLDEN[1], whole);
    let bytes = |resource| scene.plan.bytes(resource).next_multiple_of(256);
    let [a, b] = [Resource::Scratch, Resource::Palettes].map(bytes);
    let outputs = scene.make(a + b, usage);
    let buffers = scene.buffers().with(Resource::Scratch, &outputs, 0);
    let buffers = buffers.with(Resource::Palettes, &outputs, a);
    let bound = Bound::new(&scene.pipelines, &scene.plan, &buffers).unwrap();
    submit(&scene.device, &bound, 3).unwrap();

    let inputs = scene.make(1 << 20, usage);
    let (params, blob) = (0, bytes(Resource::Params));
    let poses = blob + bytes(Resource::Blob);
    let host = poses + bytes(Resource::Poses);
    let shared = scene
        .buffers()
        .with(Resource::Params, &inputs, params)
        .with(Resource::Blob, &inputs, blob)
        .with(Resource::Poses, &inputs, poses)
        .with(Resource::Host, &inputs, host);
    let bound = Bound::new(&scene.pipelines, &scene.plan, &shared).unwrap();
    submit(&scene.device, &bound, 3).unwrap();

    for written in WRITTEN {
        let buffers = shared.with(written, &inputs, host + bytes(Resource::Host));
        let Error::Shared { stage, written: found, read } = scene.refused(&buffers) else {
            panic!("{} may be read and written", written.name());
        };
        assert_eq!(found, written);
        assert!(stage.bindings().iter().any(|own| own.resource == read && !own.writable));
    }
}

const WRITTEN: [Resource; 4] =
    [Resource::Scratch, Resource::Palettes, Resource::Confidences, Resource::Out];

#[test]
fn resources_overlap_where_both_are_only_read() {
    scenes().iter().for_each(overlapping);
}

fn overlapping(scene: &Scene) {
    for first in scene.needed() {
        for second in scene.needed().filter(|second| first < *second) {
            let end = scene.plan.bytes(first).next_multiple_of(256);
            let usage = BufferUsages::STORAGE | BufferUsages::UNIFORM;
            let both = scene.make(end + scene.plan.bytes(second), usage);
            let buffers = scene.buffers().with(first, &both, 0).with(second, &both, end - 256);
            let found = Bound::new(&scene.pipelines, &scene.plan, &buffers).map(drop);
            if WRITTEN.contains(&first) || WRITTEN.contains(&second) {
                assert_eq!(found, Err(LayoutError::Overlap { first, second }.into()));
            } else {
                assert_eq!(found, Ok(()));
            }
        }
    }
}

/// Each buffer that is refused as shared is one that wgpu would refuse when the encoder finishes.
#[test]
fn wgpu_refuses_what_is_shared() {
    let scene = scene(GOLDEN[1], whole);
    let device = scene.device.device();
    let source = "@group(0) @binding(0) var<storage, read> a: array<u32>;
        @group(0) @binding(1) var<storage, read_write> b: array<u32>;
        @compute @workgroup_size(1) fn main() { b[0] = a[0]; }";
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: Default::default(),
        cache: None,
    });
    let [one, other] = [(); 2].map(|()| scene.make(1 << 16, BufferUsages::STORAGE));
    for (written, is_refused) in [(&other, false), (&one, true)] {
        let bind = |binding, buffer, offset| wgpu::BindGroupEntry {
            binding,
            resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer,
                offset,
                size: std::num::NonZero::new(256),
            }),
        };
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[bind(0, &one, 0), bind(1, written, 256)],
        });
        let scope = device.push_error_scope(ErrorFilter::Validation);
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(1, 1, 1);
        drop(pass);
        drop(encoder.finish());
        assert_eq!(pollster::block_on(scope.pop()).is_some(), is_refused);
    }
}

#[test]
fn a_buffer_of_another_device_is_refused() {
    let adapter = adapter();
    let open = || pollster::block_on(adapter.request_device(&Default::default())).unwrap().0;
    let [device, other] = [(); 2].map(|()| open());
    let model = load(GOLDEN[1]);
    let (envelope, skin) = parts(&model);
    let batch = palettes(&envelope, &skin);
    let plan = Plan::new(&model, &envelope, &batch, &limits(&device.limits())).unwrap();
    let pipelines = Pipelines::new(&device, plan.stages()).unwrap();
    let usage = BufferUsages::STORAGE | BufferUsages::UNIFORM;
    let made = |device: &wgpu::Device| {
        Resource::ALL.map(|resource| buffer(device, plan.bytes(resource).max(4), usage))
    };
    let (own, foreign) = (made(&device), made(&other));
    for resource in Resource::ALL {
        let all = Resource::ALL.into_iter().zip(own.iter().zip(&foreign));
        let buffers = all.fold(Buffers::new(), |buffers, (each, (own, foreign))| {
            buffers.with(each, if each == resource { foreign } else { own }, 0)
        });
        let found = Bound::new(&pipelines, &plan, &buffers).map(drop);
        if plan.bytes(resource) > 0 {
            assert!(matches!(found, Err(Error::Refused { making: "bind groups", .. })));
        } else {
            assert_eq!(found, Ok(()));
        }
    }
}

#[test]
fn a_stage_without_a_pipeline_or_outside_the_batch_is_refused() {
    let mut scene = scene(GOLDEN[0], whole);
    let bound = Bound::new(&scene.pipelines, &scene.plan, &scene.buffers()).unwrap();
    let mut encoder = scene.device.device().create_command_encoder(&Default::default());
    assert_eq!(
        bound.encode_stage(&mut encoder, Stage::Joints, 1),
        Err(Error::NotPlanned { stage: Stage::Joints })
    );
    let most = Stage::ALL.into_iter().filter(|stage| *stage != Stage::Skin);
    scene.pipelines = Pipelines::new(scene.device.device(), most).unwrap();
    assert_eq!(scene.refused(&scene.buffers()), Error::NoPipeline { stage: Stage::Skin });
}

#[test]
fn a_wrong_number_of_instances_records_nothing() {
    let scene = scene(GOLDEN[1], whole);
    let bound = Bound::new(&scene.pipelines, &scene.plan, &scene.buffers()).unwrap();
    let palettes = &scene.own[Resource::Palettes as usize];
    let poison = vec![0xff; palettes.size() as usize];
    scene.device.queue().write_buffer(palettes, 0, &poison);
    for (instance_len, expected) in [
        (0, LayoutError::NoInstances),
        (4, LayoutError::TooManyInstances { expected: 3, found: 4 }),
        (usize::MAX, LayoutError::TooManyInstances { expected: 3, found: usize::MAX }),
    ] {
        let mut encoder = scene.device.device().create_command_encoder(&Default::default());
        assert_eq!(bound.encode(&mut encoder, instance_len), Err(expected.into()));
        for stage in scene.plan.stages() {
            let result = bound.encode_stage(&mut encoder, stage, instance_len);
            assert_eq!(result, Err(expected.into()));
        }
        scene.device.queue().submit([encoder.finish()]);
        assert_eq!(scene.device.read_bytes(palettes).unwrap(), poison);
    }
    // Control: a correct call writes.
    submit(&scene.device, &bound, 3).unwrap();
    assert_ne!(scene.device.read_bytes(palettes).unwrap(), poison);
}

#[test]
fn limits_too_small_are_refused() {
    let adapter = adapter();
    type Change = fn(&mut Limits);
    let small: [(Change, &str); 3] = [
        (|limits| limits.max_storage_buffers_per_shader_stage = 3, "storage buffers"),
        (|limits| limits.max_compute_invocations_per_workgroup = 32, "threads"),
        (|limits| limits.max_compute_workgroups_per_dimension = 255, "workgroups"),
    ];
    for (change, name) in small {
        let mut required_limits = Limits::downlevel_defaults();
        change(&mut required_limits);
        let descriptor = wgpu::DeviceDescriptor { required_limits, ..Default::default() };
        let (device, _) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
        let refused = Pipelines::new(&device, Stage::ALL).unwrap_err();
        let Error::Layout(LayoutError::Device { name: found, .. }) = refused else {
            panic!("{refused}");
        };
        assert!(found.contains(name), "{found}");
    }
    let mut coarse = Limits::downlevel_defaults();
    coarse.min_uniform_buffer_offset_alignment = 512;
    assert_eq!(limits(&coarse).offset_alignment, 512);
}

#[test]
fn a_plan_by_larger_limits_is_refused() {
    let scene = scene(GOLDEN[1], palettes);
    let model = load(GOLDEN[1]);
    let (envelope, _) = parts(&model);
    let own = scene.device.limits();
    let refused = |batch: &Batch, limits: DeviceLimits| {
        let plan = Plan::new(&model, &envelope, batch, &limits).unwrap();
        let usage = BufferUsages::STORAGE | BufferUsages::UNIFORM;
        let own = Resource::ALL.map(|resource| scene.make(plan.bytes(resource).max(4), usage));
        let all = Resource::ALL.into_iter().zip(&own);
        let buffers = all.fold(Buffers::new(), |all, (resource, own)| all.with(resource, own, 0));
        Bound::new(&scene.pipelines, &plan, &buffers).map(drop)
    };

    let palettes = Array { offset: 0, stride: 20 << 20 };
    let wide = Batch { palettes, confidences: None, ..Batch::palettes(&envelope, 3) };
    assert_eq!(refused(&wide, own), Ok(()), "in chunks");
    let storage_binding_bytes = 1 << 30;
    let Err(Error::Layout(LayoutError::Binding { resource: Resource::Palettes, limit, .. })) =
        refused(&wide, DeviceLimits { storage_binding_bytes, ..own })
    else {
        panic!("a binding is too large");
    };
    assert_eq!(limit, own.storage_binding_bytes);

    let poses = Array { offset: 0, stride: 0 };
    let many = Batch { poses, confidences: None, ..Batch::palettes(&envelope, 70_000) };
    assert_eq!(refused(&many, own), Ok(()), "in chunks");
    let Err(Error::Layout(LayoutError::Device { found, .. })) =
        refused(&many, DeviceLimits { workgroups: 1 << 20, ..own })
    else {
        panic!("a dispatch is too large");
    };
    assert_eq!(found, u64::from(own.workgroups));
}

/// Device loss reaches only the host's callback, not an error scope. Objects of the lost device are
/// void.
#[test]
fn device_loss_reaches_only_the_hosts_callback() {
    let scene = scene(GOLDEN[1], whole);
    let device = scene.device.device();
    let (send, receive) = std::sync::mpsc::channel();
    device.set_device_lost_callback(move |_, _| send.send(()).unwrap());
    device.destroy();
    let pipelines = Pipelines::new(device, Stage::ALL).unwrap();
    let bound = Bound::new(&pipelines, &scene.plan, &scene.buffers()).unwrap();
    let mut encoder = device.create_command_encoder(&Default::default());
    assert_eq!(bound.encode(&mut encoder, 3), Ok(()));
    scene.device.queue().submit([encoder.finish()]);
    drop(device.poll(wgpu::PollType::Poll));
    assert_eq!(receive.try_recv(), Ok(()));
}

/// A mistake that cannot be detected in advance is reported by wgpu at submission.
#[test]
fn wgpu_reports_a_destroyed_buffer() {
    let scene = scene(GOLDEN[1], whole);
    let device = scene.device.device();
    let bound = Bound::new(&scene.pipelines, &scene.plan, &scene.buffers()).unwrap();
    let scope = device.push_error_scope(ErrorFilter::Validation);
    let mut encoder = device.create_command_encoder(&Default::default());
    bound.encode(&mut encoder, 3).unwrap();
    scene.own[Resource::Scratch as usize].destroy();
    scene.device.queue().submit([encoder.finish()]);
    assert!(pollster::block_on(scope.pop()).is_some());
}

fn submit(device: &Device, bound: &Bound, instance_len: usize) -> Result<(), Error> {
    let scope = device.device().push_error_scope(ErrorFilter::Validation);
    let mut encoder = device.device().create_command_encoder(&Default::default());
    bound.encode(&mut encoder, instance_len)?;
    device.queue().submit([encoder.finish()]);
    let error = pollster::block_on(scope.pop());
    assert!(error.is_none(), "{error:?}");
    Ok(())
}

fn adapter() -> wgpu::Adapter {
    let backends = wgpu::Backends::VULKAN;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let adapters = pollster::block_on(instance.enumerate_adapters(backends));
    let is_lavapipe = |adapter: &wgpu::Adapter| adapter.get_info().driver == "llvmpipe";
    adapters.into_iter().find(is_lavapipe).expect("lavapipe; install mesa-vulkan-drivers")
}
