//! The stages' pipelines on a device.

use super::error::{Error, scoped};
use crate::layout::{DeviceLimits, Resource, Stage};
use ::wgpu::{
    BindGroupLayout, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingType,
    BufferBindingType, BufferUsages, ComputePipeline, ComputePipelineDescriptor, Device,
    PipelineCompilationOptions, PipelineLayoutDescriptor, ShaderModuleDescriptor, ShaderSource,
    ShaderStages,
};

/// Converts the limits of a device for a [`crate::layout::Plan`].
///
/// Pass the limits of the open device, not those of its adapter: wgpu enforces the limits of the
/// device.
pub fn limits(limits: &::wgpu::Limits) -> DeviceLimits {
    DeviceLimits {
        storage_binding_bytes: limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
        storage_buffers: limits.max_storage_buffers_per_shader_stage,
        offset_alignment: limits
            .min_storage_buffer_offset_alignment
            .max(limits.min_uniform_buffer_offset_alignment),
        workgroup_threads: limits
            .max_compute_invocations_per_workgroup
            .min(limits.max_compute_workgroup_size_x),
        workgroups: limits.max_compute_workgroups_per_dimension,
    }
}

/// Returns the usage that a resource's buffer must have.
pub(super) fn usage(resource: Resource) -> BufferUsages {
    match resource {
        Resource::Params => BufferUsages::UNIFORM,
        _ => BufferUsages::STORAGE,
    }
}

/// Pipelines of stages on a device: made once, used for any number of models and batches.
#[derive(Clone, Debug)]
pub struct Pipelines {
    pub(super) device: Device,
    stages: Vec<(Stage, Pipeline)>,
}

/// A stage's pipeline and the layout of its bind group.
#[derive(Clone, Debug)]
pub(super) struct Pipeline {
    pub(super) pipeline: ComputePipeline,
    pub(super) layout: BindGroupLayout,
}

impl Pipelines {
    /// Compiles the pipelines of some stages: [`Stage::ALL`], those of a [`crate::layout::Plan`],
    /// or all but [`Stage::Skin`] if the host's own shaders skin. Compiling takes milliseconds a
    /// stage.
    ///
    /// # Errors
    /// - [`Error::Layout`]: the device's limits are too low for the shaders.
    /// - [`Error::OutOfMemory`]
    /// - [`Error::Refused`]: the device refuses a shader or a pipeline.
    pub fn new(device: &Device, stages: impl IntoIterator<Item = Stage>) -> Result<Self, Error> {
        limits(&device.limits()).check()?;
        let mut made: Vec<(Stage, Pipeline)> = Vec::new();
        for stage in stages {
            if made.iter().all(|(own, _)| *own != stage) {
                made.push((stage, Pipeline::new(device, stage)?));
            }
        }
        Ok(Self { device: device.clone(), stages: made })
    }

    /// Lists the stages of the pipelines.
    pub fn stages(&self) -> impl ExactSizeIterator<Item = Stage> + '_ {
        self.stages.iter().map(|(stage, _)| *stage)
    }

    pub(super) fn get(&self, stage: Stage) -> Result<&Pipeline, Error> {
        let own = self.stages.iter().find(|(own, _)| *own == stage);
        own.map(|(_, pipeline)| pipeline).ok_or(Error::NoPipeline { stage })
    }
}

impl Pipeline {
    fn new(device: &Device, stage: Stage) -> Result<Self, Error> {
        scoped(device, stage.name(), || {
            let layout = layout(device, stage);
            let source = ShaderSource::Wgsl(stage.wgsl().into());
            let label = Some(stage.name());
            let module = device.create_shader_module(ShaderModuleDescriptor { label, source });
            let whole = device.create_pipeline_layout(&PipelineLayoutDescriptor {
                label,
                bind_group_layouts: &[Some(&layout)],
                ..Default::default()
            });
            let pipeline = device.create_compute_pipeline(&ComputePipelineDescriptor {
                label,
                layout: Some(&whole),
                module: &module,
                entry_point: Some("main"),
                compilation_options: PipelineCompilationOptions::default(),
                cache: None,
            });
            Self { pipeline, layout }
        })
    }
}

/// Makes the layout of a stage's bind group from [`Stage::bindings`].
fn layout(device: &Device, stage: Stage) -> BindGroupLayout {
    let entries = stage.bindings().iter().zip(0..).map(|(own, binding)| {
        let ty = match own.resource {
            Resource::Params => BufferBindingType::Uniform,
            _ => BufferBindingType::Storage { read_only: !own.writable },
        };
        BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::COMPUTE,
            ty: BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        }
    });
    let entries: Vec<_> = entries.collect();
    let label = Some(stage.name());
    device.create_bind_group_layout(&BindGroupLayoutDescriptor { label, entries: &entries })
}
