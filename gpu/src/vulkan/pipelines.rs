//! The stages' pipelines on the host's device, and what the host must make for a plan.

use super::error::Error;
use crate::layout::{DeviceLimits, Plan, Resource, Stage};
use ash::{Device, vk};

/// The pipelines of some stages, with their layouts.
///
/// Dropping does not free the pipelines, because that takes the host's device and callbacks; call
/// [`Pipelines::destroy`]. The default has no stages.
#[derive(Debug, Default)]
pub struct Pipelines {
    stages: Vec<Pipeline>,
}

/// The Vulkan objects of one stage; null until they are made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pipeline {
    pub(super) stage: Stage,
    pub(super) set_layout: vk::DescriptorSetLayout,
    pub(super) layout: vk::PipelineLayout,
    pub(super) pipeline: vk::Pipeline,
}

impl Pipelines {
    /// Makes the pipelines of some stages: [`Plan::stages`], or [`Stage::ALL`] for any plan. The
    /// cache may be null. If an error is returned, nothing is left behind.
    ///
    /// # Errors
    /// [`Error::Vulkan`]
    ///
    /// # Safety
    /// The device must be valid, and so must the cache if it is not null. The callbacks must be as
    /// Vulkan requires, and must outlive the call. All objects are made through them.
    pub unsafe fn new(
        device: &Device,
        stages: &[Stage],
        cache: vk::PipelineCache,
        callbacks: Option<&vk::AllocationCallbacks<'_>>,
    ) -> Result<Self, Error> {
        let mut pipelines = Self { stages: Vec::with_capacity(stages.len()) };
        for &stage in stages {
            let mut made = Pipeline {
                stage,
                set_layout: vk::DescriptorSetLayout::null(),
                layout: vk::PipelineLayout::null(),
                pipeline: vk::Pipeline::null(),
            };
            // SAFETY: as our own caller promises.
            let result = unsafe { made.make(device, cache, callbacks) };
            pipelines.stages.push(made);
            if let Err(error) = result {
                // SAFETY: nothing has used the pipelines; they come from this device and these
                // callbacks.
                unsafe { pipelines.destroy(device, callbacks) };
                return Err(error);
            }
        }
        Ok(pipelines)
    }

    /// Lists the layouts of the descriptor sets of a plan, in the order in which
    /// [`super::Bound::new`] expects the sets.
    ///
    /// # Errors
    /// [`Error::NoPipeline`]
    pub fn set_layouts(&self, plan: &Plan) -> Result<Vec<vk::DescriptorSetLayout>, Error> {
        let mut layouts = Vec::with_capacity(plan.stages().len() * plan.chunks().len());
        for stage in plan.stages() {
            let layout = self.get(stage)?.set_layout;
            layouts.extend(plan.chunks().iter().map(|_| layout));
        }
        Ok(layouts)
    }

    /// Destroys the pipelines.
    ///
    /// # Safety
    /// Device and callbacks must be the ones of [`Pipelines::new`], or compatible with them. No
    /// command buffer with these pipelines may be pending or be submitted later.
    pub unsafe fn destroy(self, device: &Device, callbacks: Option<&vk::AllocationCallbacks<'_>>) {
        for own in self.stages {
            // SAFETY: as our own caller promises; Vulkan ignores null handles.
            unsafe {
                device.destroy_pipeline(own.pipeline, callbacks);
                device.destroy_pipeline_layout(own.layout, callbacks);
                device.destroy_descriptor_set_layout(own.set_layout, callbacks);
            }
        }
    }

    pub(super) fn get(&self, stage: Stage) -> Result<&Pipeline, Error> {
        let mut stages = self.stages.iter();
        stages.find(|own| own.stage == stage).ok_or(Error::NoPipeline { stage })
    }
}

impl Pipeline {
    /// Makes the objects of the stage. If a call fails, the objects made so far stay.
    ///
    /// # Safety
    /// As for [`Pipelines::new`].
    unsafe fn make(
        &mut self,
        device: &Device,
        cache: vk::PipelineCache,
        callbacks: Option<&vk::AllocationCallbacks<'_>>,
    ) -> Result<(), Error> {
        let bindings = self.stage.bindings().iter().zip(0..).map(|(binding, number)| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(number)
                .descriptor_type(descriptor_type(binding.resource))
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::COMPUTE)
        });
        let bindings: Vec<_> = bindings.collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: the bindings have distinct numbers and live through the call.
        self.set_layout = unsafe { device.create_descriptor_set_layout(&info, callbacks) }
            .map_err(Error::while_doing("making a descriptor set layout"))?;

        let set_layouts = [self.set_layout];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&set_layouts);
        // SAFETY: the set layout has just been made on this device.
        self.layout = unsafe { device.create_pipeline_layout(&info, callbacks) }
            .map_err(Error::while_doing("making a pipeline layout"))?;

        let words = self.stage.spirv().as_chunks::<4>().0;
        let words: Vec<_> = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: the words are our shader, which the tests validate.
        let module = unsafe { device.create_shader_module(&info, callbacks) }
            .map_err(Error::while_doing("making a shader module"))?;

        let shader = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(c"main");
        let infos = [vk::ComputePipelineCreateInfo::default().stage(shader).layout(self.layout)];
        // SAFETY: module and layout have just been made on this device, and fit each other.
        let result = unsafe { device.create_compute_pipelines(cache, &infos, callbacks) };
        // SAFETY: a module may be destroyed once the call that uses it has returned.
        unsafe { device.destroy_shader_module(module, callbacks) };
        // Each call makes one pipeline, so a failed call has made none.
        let made = result.map_err(|(_, result)| result);
        let made = made.map_err(Error::while_doing("making a compute pipeline"))?;
        self.pipeline = made.first().copied().unwrap_or_default();
        Ok(())
    }
}

/// Returns the descriptor type of a resource.
pub(super) fn descriptor_type(resource: Resource) -> vk::DescriptorType {
    match resource {
        Resource::Params => vk::DescriptorType::UNIFORM_BUFFER,
        _ => vk::DescriptorType::STORAGE_BUFFER,
    }
}

/// Converts a device's limits into [`DeviceLimits`].
pub fn limits(device: &vk::PhysicalDeviceLimits) -> DeviceLimits {
    let alignment =
        device.min_storage_buffer_offset_alignment.max(device.min_uniform_buffer_offset_alignment);
    let [x, y, _] = device.max_compute_work_group_count;
    DeviceLimits {
        storage_binding_bytes: device.max_storage_buffer_range.into(),
        storage_buffers: device.max_per_stage_descriptor_storage_buffers,
        offset_alignment: u32::try_from(alignment).unwrap_or(u32::MAX),
        workgroup_threads: device
            .max_compute_work_group_invocations
            .min(device.max_compute_work_group_size[0]),
        workgroups: x.min(y),
    }
}

/// Returns the usage that a resource's buffer must have for this crate. The host adds its own
/// usages, for example for uploads or vertex input.
pub fn usage(resource: Resource) -> vk::BufferUsageFlags {
    match resource {
        Resource::Params => vk::BufferUsageFlags::UNIFORM_BUFFER,
        _ => vk::BufferUsageFlags::STORAGE_BUFFER,
    }
}

/// Counts the descriptors of a plan by their type.
pub fn pool_sizes(plan: &Plan) -> [vk::DescriptorPoolSize; 2] {
    let storage = plan.stages().map(|stage| stage.bindings().len() - 1).sum::<usize>();
    let size = |ty, len: usize| vk::DescriptorPoolSize { ty, descriptor_count: len as u32 };
    [
        size(vk::DescriptorType::UNIFORM_BUFFER, set_len(plan) as usize),
        size(vk::DescriptorType::STORAGE_BUFFER, storage * plan.chunks().len()),
    ]
}

/// Counts the descriptor sets of a plan: one for each stage and chunk.
pub fn set_len(plan: &Plan) -> u32 {
    (plan.stages().len() * plan.chunks().len()) as u32
}
