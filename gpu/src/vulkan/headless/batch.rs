//! A batch that owns its buffers.

use super::super::bound::{Bound, Buffers, barrier};
use super::super::pipelines::{pool_sizes, set_len, usage};
use super::device::{Commands, Device};
use super::instance::while_doing;
use super::memory::Memory;
use crate::headless::{self, DeviceInfo, HeadlessError, Uploaded};
use crate::layout::{DeviceLimits, LayoutError, Plan, Resource, Stage};
use ash::vk::{self, AccessFlags as Access, PipelineStageFlags as Stages};
use std::time::{Duration, Instant};

/// A batch on a device, with its buffers in the device's own memory.
pub struct VulkanBatch<'d> {
    memory: BatchMemory<'d>,
    bound: Bound,
}

impl<'d> VulkanBatch<'d> {
    /// Returns the bound plan.
    pub fn bound(&self) -> &Bound {
        &self.bound
    }

    /// Returns a resource's buffer.
    ///
    /// # Errors
    /// [`crate::layout::LayoutError::Missing`]: the plan does not need the resource.
    pub fn memory(&self, resource: Resource) -> Result<&Memory<'d>, HeadlessError> {
        self.memory.buffer(resource)
    }
}

impl Uploaded for VulkanBatch<'_> {
    fn write(
        &mut self,
        resource: Resource,
        first: usize,
        floats: &[f32],
    ) -> Result<(), HeadlessError> {
        let bytes: Vec<u8> = floats.iter().flat_map(|float| float.to_le_bytes()).collect();
        self.memory.write(resource, (first as u64).saturating_mul(4), &bytes)
    }

    fn run(&mut self, instance_len: usize) -> Result<(), HeadlessError> {
        self.memory.submit(|device, commands| {
            uploaded(device, commands);
            // SAFETY: the command buffer is being recorded; the barrier above is the one that
            // `record` requires.
            Ok(unsafe { self.bound.record(device, commands, instance_len) }?)
        })
    }

    fn time_stage(
        &mut self,
        stage: Stage,
        instance_len: usize,
        repeat_len: usize,
    ) -> Result<Duration, HeadlessError> {
        let start = Instant::now();
        self.memory.submit(|device, commands| {
            uploaded(device, commands);
            for _ in 0..repeat_len {
                // SAFETY: as above; the second barrier makes the writes of other stages visible.
                unsafe {
                    barrier(device, commands);
                    self.bound.record_stage(device, commands, stage, instance_len)?;
                }
            }
            Ok(())
        })?;
        Ok(start.elapsed())
    }

    fn read(&mut self, resource: Resource) -> Result<Vec<f32>, HeadlessError> {
        let bytes = self.memory.read(resource)?;
        let words = bytes.as_chunks::<4>().0;
        Ok(words.iter().map(|word| f32::from_le_bytes(*word)).collect())
    }
}

impl Device {
    /// Allocates the buffers of a batch, as [`headless::Device::upload`], but returns the concrete
    /// type.
    ///
    /// # Errors
    /// [`HeadlessError`]
    pub fn batch(&self, blob: &[u8], plan: &Plan) -> Result<VulkanBatch<'_>, HeadlessError> {
        let mut memory = BatchMemory::new(self, plan)?;
        memory.write(Resource::Params, 0, &plan.params())?;
        // Bindings have whole words.
        let mut blob = blob.to_vec();
        blob.resize(blob.len().next_multiple_of(4), 0);
        memory.write(Resource::Blob, 0, &blob)?;
        let (sets, buffers) = (memory.sets(plan)?, memory.buffers());
        // SAFETY: buffers and sets have just been made for this plan, and live as long as the
        // batch.
        let bound = unsafe { Bound::new(self.device(), self.pipelines(), plan, &buffers, &sets) }?;
        Ok(VulkanBatch { memory, bound })
    }
}

impl headless::Device for Device {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn limits(&self) -> DeviceLimits {
        self.limits
    }

    fn upload(&self, blob: &[u8], plan: &Plan) -> Result<Box<dyn Uploaded + '_>, HeadlessError> {
        Ok(Box::new(self.batch(blob, plan)?))
    }

    fn message_len(&self) -> Option<usize> {
        self.messages().map(|messages| messages.len())
    }
}

/// The memory of a batch: buffers, descriptor pool and a command buffer for copies; freed when
/// dropped.
struct BatchMemory<'d> {
    device: &'d Device,
    buffers: [Option<Memory<'d>>; Resource::ALL.len()],
    sets: vk::DescriptorPool,
    commands: Commands<'d>,
}

impl<'d> BatchMemory<'d> {
    /// Allocates a plan's buffers, filled with zeros.
    fn new(device: &'d Device, plan: &Plan) -> Result<Self, HeadlessError> {
        let mut own = Self {
            device,
            buffers: Default::default(),
            sets: vk::DescriptorPool::null(),
            commands: Commands::new(device)?,
        };
        for (resource, buffer) in Resource::ALL.into_iter().zip(&mut own.buffers) {
            let bytes = plan.bytes(resource).next_multiple_of(4);
            if bytes > 0 {
                *buffer = Some(Memory::local(device, bytes, usage(resource))?);
            }
        }
        own.submit(|device, commands| {
            for memory in own.buffers.iter().flatten() {
                let (buffer, whole) = (memory.buffer(), vk::WHOLE_SIZE);
                // SAFETY: the buffer belongs to the device, and can be copied to.
                unsafe { device.cmd_fill_buffer(commands, buffer, 0, whole, 0) };
            }
            Ok(())
        })?;
        Ok(own)
    }

    /// Allocates a plan's descriptor sets.
    fn sets(&mut self, plan: &Plan) -> Result<Vec<vk::DescriptorSet>, HeadlessError> {
        let layouts = self.device.pipelines().set_layouts(plan)?;
        let sizes = pool_sizes(plan);
        let info =
            vk::DescriptorPoolCreateInfo::default().pool_sizes(&sizes).max_sets(set_len(plan));
        // SAFETY: the device is valid.
        self.sets = unsafe { self.device.device().create_descriptor_pool(&info, None) }
            .map_err(while_doing("making a descriptor pool"))?;
        let info = vk::DescriptorSetAllocateInfo::default()
            .descriptor_pool(self.sets)
            .set_layouts(&layouts);
        // SAFETY: the pool has just been made, and the layouts belong to this device.
        unsafe { self.device.device().allocate_descriptor_sets(&info) }
            .map_err(while_doing("allocating descriptor sets"))
    }

    /// Returns the buffers by resource.
    fn buffers(&self) -> Buffers {
        let own = Resource::ALL.into_iter().zip(&self.buffers);
        own.fold(Buffers::default(), |buffers, (resource, memory)| match memory {
            Some(memory) => buffers.with(resource, memory.buffer(), 0, memory.bytes()),
            None => buffers,
        })
    }

    fn buffer(&self, resource: Resource) -> Result<&Memory<'d>, HeadlessError> {
        let memory = self.buffers[resource as usize].as_ref();
        memory.ok_or(HeadlessError::Layout(LayoutError::Missing { resource }))
    }

    fn write(&self, resource: Resource, first: u64, bytes: &[u8]) -> Result<(), HeadlessError> {
        let to = self.buffer(resource)?;
        let least = first.saturating_add(bytes.len() as u64);
        if least > to.bytes() {
            return Err(LayoutError::TooShort { resource, least, found: to.bytes() }.into());
        }
        if bytes.is_empty() {
            return Ok(());
        }
        let mut from =
            Memory::staging(self.device, bytes.len() as u64, vk::BufferUsageFlags::empty())?;
        from.fill(bytes)?;
        self.copy(&from, to, first)
    }

    fn read(&self, resource: Resource) -> Result<Vec<u8>, HeadlessError> {
        let from = self.buffer(resource)?;
        let to = Memory::staging(self.device, from.bytes(), vk::BufferUsageFlags::empty())?;
        self.copy(from, &to, 0)?;
        let mut bytes = vec![0; from.bytes() as usize];
        to.copy(&mut bytes)?;
        Ok(bytes)
    }

    /// Records, submits, and waits.
    fn submit(
        &self,
        record: impl FnOnce(&ash::Device, vk::CommandBuffer) -> Result<(), HeadlessError>,
    ) -> Result<(), HeadlessError> {
        // SAFETY: the callers in this file record valid commands.
        unsafe { self.commands.submit(record) }
    }

    /// Copies a whole buffer into another, starting at byte `first`.
    fn copy(&self, from: &Memory<'_>, to: &Memory<'_>, first: u64) -> Result<(), HeadlessError> {
        let regions = [vk::BufferCopy { src_offset: 0, dst_offset: first, size: from.bytes() }];
        self.submit(|device, commands| {
            let wrote = Access::SHADER_WRITE | Access::TRANSFER_WRITE;
            let copies = Access::TRANSFER_READ | Access::TRANSFER_WRITE;
            let stages = Stages::COMPUTE_SHADER | Stages::TRANSFER;
            record_barrier(device, commands, (stages, wrote), (Stages::TRANSFER, copies));
            // SAFETY: both buffers belong to the device and hold the region.
            unsafe {
                device.cmd_copy_buffer(commands, from.buffer(), to.buffer(), &regions);
            }
            record_barrier(
                device,
                commands,
                (Stages::TRANSFER, Access::TRANSFER_WRITE),
                (Stages::HOST, Access::HOST_READ),
            );
            Ok(())
        })
    }
}

impl Drop for BatchMemory<'_> {
    fn drop(&mut self) {
        // SAFETY: every submission has been waited for.
        unsafe { self.device.device().destroy_descriptor_pool(self.sets, None) };
    }
}

/// Records a barrier that makes uploads visible to the stages.
fn uploaded(device: &ash::Device, commands: vk::CommandBuffer) {
    let uses = Access::SHADER_READ | Access::SHADER_WRITE | Access::UNIFORM_READ;
    let before = (Stages::TRANSFER, Access::TRANSFER_WRITE);
    record_barrier(device, commands, before, (Stages::COMPUTE_SHADER, uses));
}

/// Records a barrier into a command buffer that is being recorded.
fn record_barrier(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    before: (Stages, Access),
    after: (Stages, Access),
) {
    let memory = [vk::MemoryBarrier::default().src_access_mask(before.1).dst_access_mask(after.1)];
    let none = vk::DependencyFlags::empty();
    // SAFETY: the command buffer is valid and being recorded.
    unsafe { device.cmd_pipeline_barrier(commands, before.0, after.0, none, &memory, &[], &[]) };
}
