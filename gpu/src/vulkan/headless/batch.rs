//! A batch whose buffers the helper owns.

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
    held: Held<'d>,
    bound: Bound,
}

impl<'d> VulkanBatch<'d> {
    fn new(device: &'d Device, blob: &[u8], plan: &Plan) -> Result<Self, HeadlessError> {
        let mut held = Held::new(device, plan)?;
        held.write(Resource::Params, 0, &plan.params())?;
        // Words are bound.
        let mut blob = blob.to_vec();
        blob.resize(blob.len().next_multiple_of(4), 0);
        held.write(Resource::Blob, 0, &blob)?;
        let pipelines = device.pipelines();
        let (sets, buffers) = (held.sets(plan)?, held.buffers());
        // SAFETY: buffers and sets have just been made for this plan, and live as long as the batch.
        let bound = unsafe { Bound::new(device.device(), pipelines, plan, &buffers, &sets) }?;
        Ok(Self { held, bound })
    }

    /// Returns what is recorded.
    pub fn bound(&self) -> &Bound {
        &self.bound
    }

    /// Returns a resource's buffer.
    ///
    /// # Errors
    /// [`crate::layout::LayoutError::Missing`]: the plan does not need it.
    pub fn memory(&self, resource: Resource) -> Result<&Memory<'d>, HeadlessError> {
        self.held.memory(resource)
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
        self.held.write(resource, (first as u64).saturating_mul(4), &bytes)
    }

    fn run(&mut self, instance_len: usize) -> Result<(), HeadlessError> {
        self.held.submit(|device, commands| {
            uploaded(device, commands);
            // SAFETY: the command buffer is being recorded; the barrier above is what is asked for.
            Ok(unsafe { self.bound.record(device, commands, instance_len) }?)
        })
    }

    fn run_stage(&mut self, stage: Stage, instance_len: usize) -> Result<(), HeadlessError> {
        self.held.submit(|device, commands| {
            uploaded(device, commands);
            // SAFETY: likewise; the second barrier is for what other stages have written.
            unsafe {
                barrier(device, commands);
                Ok(self.bound.record_stage(device, commands, stage, instance_len)?)
            }
        })
    }

    fn time_stage(
        &mut self,
        stage: Stage,
        instance_len: usize,
        repeat_len: usize,
    ) -> Result<Duration, HeadlessError> {
        let start = Instant::now();
        self.held.submit(|device, commands| {
            uploaded(device, commands);
            for _ in 0..repeat_len {
                // SAFETY: as in `run_stage`.
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
        let bytes = self.held.read(resource)?;
        let words = bytes.as_chunks::<4>().0;
        Ok(words.iter().map(|word| f32::from_le_bytes(*word)).collect())
    }
}

impl Device {
    /// Allocates the buffers of a batch: [`headless::Device::upload`] with a type that shows more.
    ///
    /// # Errors
    /// [`HeadlessError`]
    pub fn batch(&self, blob: &[u8], plan: &Plan) -> Result<VulkanBatch<'_>, HeadlessError> {
        VulkanBatch::new(self, blob, plan)
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

/// Freed when dropped.
struct Held<'d> {
    device: &'d Device,
    memory: [Option<Memory<'d>>; Resource::ALL.len()],
    sets: vk::DescriptorPool,
    commands: Commands<'d>,
}

impl<'d> Held<'d> {
    /// Allocates a plan's buffers, zero at first.
    fn new(device: &'d Device, plan: &Plan) -> Result<Self, HeadlessError> {
        let mut held = Self {
            device,
            memory: [const { None }; Resource::ALL.len()],
            sets: vk::DescriptorPool::null(),
            commands: Commands::new(device)?,
        };
        for resource in Resource::ALL {
            let bytes = plan.bytes(resource);
            if bytes > 0 {
                let memory = Memory::local(device, bytes.next_multiple_of(4), usage(resource))?;
                held.memory[resource as usize] = Some(memory);
            }
        }
        held.clear()?;
        Ok(held)
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
        // SAFETY: the pool has just been made, the layouts are of this device.
        unsafe { self.device.device().allocate_descriptor_sets(&info) }
            .map_err(while_doing("allocating descriptor sets"))
    }

    /// Returns the buffers as the stages take them.
    fn buffers(&self) -> Buffers {
        let own = Resource::ALL.into_iter().zip(&self.memory);
        own.fold(Buffers::default(), |buffers, (resource, memory)| match memory {
            Some(memory) => buffers.with(resource, memory.buffer(), 0, memory.bytes()),
            None => buffers,
        })
    }

    fn memory(&self, resource: Resource) -> Result<&Memory<'d>, HeadlessError> {
        let memory = self.memory[resource as usize].as_ref();
        memory.ok_or(HeadlessError::Layout(LayoutError::Missing { resource }))
    }

    fn write(&self, resource: Resource, first: u64, bytes: &[u8]) -> Result<(), HeadlessError> {
        let to = self.memory(resource)?;
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
        let from = self.memory(resource)?;
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
        // SAFETY: those who call this record what is valid.
        unsafe { self.commands.submit(record) }
    }

    fn clear(&self) -> Result<(), HeadlessError> {
        self.submit(|device, commands| {
            for memory in self.memory.iter().flatten() {
                let (buffer, whole) = (memory.buffer(), vk::WHOLE_SIZE);
                // SAFETY: the buffer is the device's, and may be copied to.
                unsafe { device.cmd_fill_buffer(commands, buffer, 0, whole, 0) };
            }
            Ok(())
        })
    }

    /// Copies the whole of a buffer to a place in another.
    fn copy(&self, from: &Memory<'_>, to: &Memory<'_>, first: u64) -> Result<(), HeadlessError> {
        let regions = [vk::BufferCopy { src_offset: 0, dst_offset: first, size: from.bytes() }];
        self.submit(|device, commands| {
            let wrote = Access::SHADER_WRITE | Access::TRANSFER_WRITE;
            let copies = Access::TRANSFER_READ | Access::TRANSFER_WRITE;
            let stages = Stages::COMPUTE_SHADER | Stages::TRANSFER;
            record_barrier(device, commands, (stages, wrote), (Stages::TRANSFER, copies));
            // SAFETY: both are the device's and hold the region.
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

impl Drop for Held<'_> {
    fn drop(&mut self) {
        // SAFETY: every submission has been waited for.
        unsafe { self.device.device().destroy_descriptor_pool(self.sets, None) };
    }
}

/// Records that uploads are visible to the stages.
fn uploaded(device: &ash::Device, commands: vk::CommandBuffer) {
    let uses = Access::SHADER_READ | Access::SHADER_WRITE | Access::UNIFORM_READ;
    let before = (Stages::TRANSFER, Access::TRANSFER_WRITE);
    record_barrier(device, commands, before, (Stages::COMPUTE_SHADER, uses));
}

/// Records a barrier, while the command buffer is being recorded.
fn record_barrier(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    before: (Stages, Access),
    after: (Stages, Access),
) {
    let memory = [vk::MemoryBarrier::default().src_access_mask(before.1).dst_access_mask(after.1)];
    let none = vk::DependencyFlags::empty();
    // SAFETY: the command buffer is valid, and as said.
    unsafe { device.cmd_pipeline_barrier(commands, before.0, after.0, none, &memory, &[], &[]) };
}
