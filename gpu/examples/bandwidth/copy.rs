//! A copy of a buffer by a shader: the bandwidth that shaders reach. A device's copy commands may
//! use a slower path.

use crate::Result;
use sinew_gpu::wgpu::headless::Device;
use std::time::{Duration, Instant};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BufferDescriptor, BufferUsages,
    ComputePassDescriptor, ComputePipeline, ComputePipelineDescriptor, PipelineCompilationOptions,
    ShaderModuleDescriptor, ShaderSource,
};

const SHADER: &str = "
@group(0) @binding(0) var<storage, read> source: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> copy: array<vec4<u32>>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&copy) {
        copy[id.x] = source[id.x];
    }
}
";

/// Bytes that a workgroup copies.
const WORKGROUP: u64 = 256 * 16;

/// A pipeline that copies one buffer to another.
pub(crate) struct Copy<'d> {
    device: &'d Device,
    pipeline: ComputePipeline,
    buffers: BindGroup,
    workgroups: u32,
}

impl<'d> Copy<'d> {
    /// Allocates two buffers of at least `bytes` bytes.
    pub(crate) fn new(device: &'d Device, bytes: u64) -> Result<Self> {
        let (own, label) = (device.device(), None);
        let source = ShaderSource::Wgsl(SHADER.into());
        let module = own.create_shader_module(ShaderModuleDescriptor { label, source });
        let pipeline = own.create_compute_pipeline(&ComputePipelineDescriptor {
            label,
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: PipelineCompilationOptions::default(),
            cache: None,
        });
        let (size, usage) = (bytes.next_multiple_of(16), BufferUsages::STORAGE);
        let descriptor = BufferDescriptor { label, size, usage, mapped_at_creation: false };
        let buffers = [(); 2].map(|()| own.create_buffer(&descriptor));
        let entries = [0, 1].map(|binding| BindGroupEntry {
            binding,
            resource: buffers[binding as usize].as_entire_binding(),
        });
        let layout = &pipeline.get_bind_group_layout(0);
        let buffers =
            own.create_bind_group(&BindGroupDescriptor { label, layout, entries: &entries });
        Ok(Self { device, pipeline, buffers, workgroups: size.div_ceil(WORKGROUP).try_into()? })
    }

    /// Measures the time of `repeat_len` copies in one submission.
    pub(crate) fn time(&self, repeat_len: usize) -> Result<Duration> {
        let start = Instant::now();
        self.device.submit(|encoder| {
            let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.buffers, &[]);
            for _ in 0..repeat_len {
                pass.dispatch_workgroups(self.workgroups, 1, 1);
            }
            Ok(())
        })?;
        Ok(start.elapsed())
    }
}
