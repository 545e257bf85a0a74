//! The stages' pipelines on the host's device.

use super::error::Error;
use crate::layout::{DeviceLimits, Plan, Resource, Stage};
use ash::{Device, vk};

/// Bindings of the stage that has the most.
const BINDINGS_MAX: usize = 5;

/// The pipelines of some stages, with their layouts.
///
/// They are not freed when dropped: that takes the host's device and callbacks, which only
/// [`Pipelines::destroy`] is given. The default is of no stage.
#[derive(Debug, Default)]
pub struct Pipelines {
    stages: Vec<Pipeline>,
}

/// What one stage needs; null until it is made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pipeline {
    pub(super) stage: Stage,
    pub(super) set_layout: vk::DescriptorSetLayout,
    pub(super) layout: vk::PipelineLayout,
    pub(super) pipeline: vk::Pipeline,
}

impl Pipelines {
    /// Makes the pipelines of some stages: [`Plan::stages`], or [`Stage::ALL`] to serve any plan. The
    /// cache may be null. Where an error is returned, nothing is left behind.
    ///
    /// # Errors
    /// [`Error::Vulkan`]
    ///
    /// # Safety
    /// The device must be valid, and so must the cache if it is not null. The callbacks must be as
    /// Vulkan asks, and outlive the call; all that is made goes through them.
    pub unsafe fn new(
        device: &Device,
        stages: &[Stage],
        cache: vk::PipelineCache,
        callbacks: Option<&vk::AllocationCallbacks<'_>>,
    ) -> Result<Self, Error> {
        let mut pipelines = Self { stages: Vec::with_capacity(stages.len()) };
        for &stage in stages {
            // SAFETY: as our own caller promises.
            let (made, result) = unsafe { Pipeline::new(device, stage, cache, callbacks) };
            pipelines.stages.push(made);
            if let Err(error) = result {
                // SAFETY: nothing has used them, and they come from this device and these callbacks.
                unsafe { pipelines.destroy(device, callbacks) };
                return Err(error);
            }
        }
        Ok(pipelines)
    }

    /// Lists the layouts of the descriptor sets that a plan takes, in the order in which
    /// [`super::Bound::new`] takes the sets.
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

    /// Destroys them.
    ///
    /// # Safety
    /// Device and callbacks must be those, or compatible with those, that they were made with. No
    /// command buffer in which they are recorded may be pending, or be submitted later.
    pub unsafe fn destroy(self, device: &Device, callbacks: Option<&vk::AllocationCallbacks<'_>>) {
        for own in self.stages {
            // SAFETY: as our own caller promises; Vulkan ignores those that are null.
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
    /// Returns what it could make, too, if it fails.
    ///
    /// # Safety
    /// As for [`Pipelines::new`].
    unsafe fn new(
        device: &Device,
        stage: Stage,
        cache: vk::PipelineCache,
        callbacks: Option<&vk::AllocationCallbacks<'_>>,
    ) -> (Self, Result<(), Error>) {
        let mut made = Self {
            stage,
            set_layout: vk::DescriptorSetLayout::null(),
            layout: vk::PipelineLayout::null(),
            pipeline: vk::Pipeline::null(),
        };
        // SAFETY: as our own caller promises.
        let result = unsafe { made.make(device, cache, callbacks) };
        (made, result)
    }

    /// # Safety
    /// As for [`Pipelines::new`].
    unsafe fn make(
        &mut self,
        device: &Device,
        cache: vk::PipelineCache,
        callbacks: Option<&vk::AllocationCallbacks<'_>>,
    ) -> Result<(), Error> {
        let (bindings, len) = bindings(self.stage);
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings[..len]);
        // SAFETY: the bindings have numbers of their own and live through the call.
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
        // SAFETY: the words are those of our shader, which the tests validate.
        let module = unsafe { device.create_shader_module(&info, callbacks) }
            .map_err(Error::while_doing("making a shader module"))?;

        let shader = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(c"main");
        let infos = [vk::ComputePipelineCreateInfo::default().stage(shader).layout(self.layout)];
        // SAFETY: module and layout have just been made on this device, and suit each other.
        let result = unsafe { device.create_compute_pipelines(cache, &infos, callbacks) };
        // SAFETY: a module may go as soon as the call that uses it is over.
        unsafe { device.destroy_shader_module(module, callbacks) };
        // One pipeline a call: where it fails there is none.
        let made = result.map_err(|(_, result)| result);
        let made = made.map_err(Error::while_doing("making a compute pipeline"))?;
        self.pipeline = made.first().copied().unwrap_or_default();
        Ok(())
    }
}

/// Returns a stage's bindings and how many there are.
fn bindings(stage: Stage) -> ([vk::DescriptorSetLayoutBinding<'static>; BINDINGS_MAX], usize) {
    let mut bindings = [vk::DescriptorSetLayoutBinding::default(); BINDINGS_MAX];
    let own = stage.bindings();
    for ((number, out), binding) in (0..).zip(&mut bindings).zip(own) {
        *out = vk::DescriptorSetLayoutBinding::default()
            .binding(number)
            .descriptor_type(descriptor_type(binding.resource))
            .descriptor_count(1)
            .stage_flags(vk::ShaderStageFlags::COMPUTE);
    }
    (bindings, own.len())
}

/// Returns the descriptor type of a resource.
pub(super) fn descriptor_type(resource: Resource) -> vk::DescriptorType {
    match resource {
        Resource::Params => vk::DescriptorType::UNIFORM_BUFFER,
        _ => vk::DescriptorType::STORAGE_BUFFER,
    }
}

/// Returns what a device's limits are in terms of the layout.
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

/// Returns the usage that a resource's buffer must have for us; the host adds its own, such as that
/// of an upload or of vertex input.
pub fn usage(resource: Resource) -> vk::BufferUsageFlags {
    match resource {
        Resource::Params => vk::BufferUsageFlags::UNIFORM_BUFFER,
        _ => vk::BufferUsageFlags::STORAGE_BUFFER,
    }
}

/// Counts the descriptors of a plan, by their type.
pub fn pool_sizes(plan: &Plan) -> [vk::DescriptorPoolSize; 2] {
    let storage = plan.stages().map(|stage| stage.bindings().len() - 1).sum::<usize>();
    let size = |ty, len: usize| vk::DescriptorPoolSize { ty, descriptor_count: len as u32 };
    [
        size(vk::DescriptorType::UNIFORM_BUFFER, set_len(plan) as usize),
        size(vk::DescriptorType::STORAGE_BUFFER, storage * plan.chunks().len()),
    ]
}

/// Counts the descriptor sets of a plan: one a stage and chunk.
pub fn set_len(plan: &Plan) -> u32 {
    (plan.stages().len() * plan.chunks().len()) as u32
}
