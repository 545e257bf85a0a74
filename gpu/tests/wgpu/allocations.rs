//! Recording a frame makes exactly the allocations that wgpu makes for the same calls.

use crate::allocator::allocated;
use crate::common::{GOLDEN, GOLDEN_STRETCH, load, parts};
use sinew_gpu::headless::Device as _;
use sinew_gpu::layout::{Batch, Plan, Resource, Stage};
use sinew_gpu::wgpu::headless::Device;
use sinew_gpu::wgpu::{Bound, Buffers, Pipelines};
use std::num::NonZero;
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, Buffer, BufferBinding,
    BufferDescriptor, BufferUsages, CommandEncoder, ComputePipeline, ComputePipelineDescriptor,
    ShaderModuleDescriptor, ShaderSource,
};

const INSTANCES: usize = 5;
/// Frames that are not counted: wgpu's own lists still grow.
const WARM_UP: usize = 20;
const FRAMES: usize = 50;

/// Records frames, and returns the allocations and bytes of each frame after the warm-up.
fn counts(device: &Device, mut record: impl FnMut(&mut CommandEncoder)) -> Vec<[usize; 2]> {
    let mut out = Vec::with_capacity(FRAMES);
    for frame in 0..WARM_UP + FRAMES {
        let mut encoder = device.device().create_command_encoder(&Default::default());
        let [count, bytes] = allocated();
        record(&mut encoder);
        let [count_after, bytes_after] = allocated();
        if frame >= WARM_UP {
            out.push([count_after - count, bytes_after - bytes]);
        }
        device.queue().submit([encoder.finish()]);
        device.device().poll(wgpu::PollType::wait_indefinitely()).unwrap();
    }
    out
}

/// A stage as a host would record it with wgpu alone.
struct Raw {
    pipeline: ComputePipeline,
    bind_group: BindGroup,
    workgroups: [u32; 2],
}

impl Raw {
    fn new(device: &wgpu::Device, plan: &Plan, own: &[Buffer], stage: Stage) -> Self {
        let label = None;
        let source = ShaderSource::Wgsl(stage.wgsl().into());
        let module = device.create_shader_module(ShaderModuleDescriptor { label, source });
        let pipeline = device.create_compute_pipeline(&ComputePipelineDescriptor {
            label,
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        });
        let entries = stage.bindings().iter().zip(0..).map(|(own_binding, binding)| {
            let (bound, span) = plan.chunks()[0].bound(own_binding.resource);
            let (span, buffer) = (span.unwrap(), &own[bound as usize]);
            let (offset, size) = (span.offset, NonZero::new(span.bytes));
            let resource = BindingResource::Buffer(BufferBinding { buffer, offset, size });
            BindGroupEntry { binding, resource }
        });
        let entries: Vec<_> = entries.collect();
        let layout = &pipeline.get_bind_group_layout(0);
        let bind_group =
            device.create_bind_group(&BindGroupDescriptor { label, layout, entries: &entries });
        let workgroups = plan.workgroups(stage, &plan.chunks()[0], INSTANCES).unwrap();
        Self { pipeline, bind_group, workgroups }
    }
}

#[test]
fn a_frame_allocates_no_more_than_wgpu_does() {
    let device = Device::of_driver("llvmpipe", false)
        .unwrap_or_else(|error| panic!("{error}; install mesa-vulkan-drivers"));
    for bytes in GOLDEN.into_iter().chain(GOLDEN_STRETCH) {
        let model = load(bytes);
        let (envelope, skin) = parts(&model);
        let batch = Batch::skinned(&envelope, &skin, INSTANCES);
        let plan = Plan::new(&model, &envelope, &batch, &device.limits()).unwrap();
        let own = Resource::ALL.map(|resource| {
            device.device().create_buffer(&BufferDescriptor {
                label: None,
                size: plan.bytes(resource).max(4),
                usage: BufferUsages::STORAGE | BufferUsages::UNIFORM,
                mapped_at_creation: false,
            })
        });
        let all = Resource::ALL.into_iter().zip(&own);
        let buffers = all.fold(Buffers::new(), |all, (resource, own)| all.with(resource, own, 0));
        let pipelines = Pipelines::new(device.device(), plan.stages()).unwrap();
        let bound = Bound::new(&pipelines, &plan, &buffers).unwrap();
        let raw = plan.stages().map(|stage| Raw::new(device.device(), &plan, &own, stage));
        let raw: Vec<_> = raw.collect();

        let expected = counts(&device, |encoder| {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            for Raw { pipeline, bind_group, workgroups: [x, y] } in &raw {
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, bind_group, &[]);
                pass.dispatch_workgroups(*x, *y, 1);
            }
        });
        let found = counts(&device, |encoder| bound.encode(encoder, INSTANCES).unwrap());
        let control = counts(&device, |encoder| {
            bound.encode(encoder, INSTANCES).unwrap();
            drop(std::hint::black_box(Box::new(1u8)));
        });
        eprintln!("{:?}: {:?} a frame", envelope.predictor(), found[0]);
        assert_eq!(found, expected);
        assert_ne!(control, expected, "an allocation more is seen");
    }
}
