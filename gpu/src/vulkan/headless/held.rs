//! What a batch holds on a device: buffers, descriptor pool and a command buffer to copy with.

use super::super::bound::Buffers;
use super::super::requirements::{pool_sizes, set_len, usage};
use super::commands::Commands;
use super::device::Device;
use super::error::while_doing;
use super::memory::Memory;
use crate::headless::HeadlessError;
use crate::layout::{LayoutError, Plan, Resource};
use ash::vk::{self, AccessFlags as Access, PipelineStageFlags as Stages};

/// Freed when dropped.
pub(super) struct Held<'d> {
    device: &'d Device,
    memory: [Option<Memory<'d>>; Resource::ALL.len()],
    sets: vk::DescriptorPool,
    commands: Commands<'d>,
}

impl<'d> Held<'d> {
    /// Allocates a plan's buffers, zero at first.
    pub(super) fn new(device: &'d Device, plan: &Plan) -> Result<Self, HeadlessError> {
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
    pub(super) fn sets(&mut self, plan: &Plan) -> Result<Vec<vk::DescriptorSet>, HeadlessError> {
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
    pub(super) fn buffers(&self) -> Buffers {
        let own = Resource::ALL.into_iter().zip(&self.memory);
        own.fold(Buffers::default(), |buffers, (resource, memory)| match memory {
            Some(memory) => buffers.with(resource, memory.buffer(), 0, memory.bytes()),
            None => buffers,
        })
    }

    pub(super) fn memory(&self, resource: Resource) -> Result<&Memory<'d>, HeadlessError> {
        let memory = self.memory[resource as usize].as_ref();
        memory.ok_or(HeadlessError::Layout(LayoutError::Missing { resource }))
    }

    pub(super) fn write(
        &self,
        resource: Resource,
        first: u64,
        bytes: &[u8],
    ) -> Result<(), HeadlessError> {
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

    pub(super) fn read(&self, resource: Resource) -> Result<Vec<u8>, HeadlessError> {
        let from = self.memory(resource)?;
        let to = Memory::staging(self.device, from.bytes(), vk::BufferUsageFlags::empty())?;
        self.copy(from, &to, 0)?;
        let mut bytes = vec![0; from.bytes() as usize];
        to.copy(&mut bytes)?;
        Ok(bytes)
    }

    /// Records, submits, and waits.
    pub(super) fn submit(
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
            barrier(device, commands, (stages, wrote), (Stages::TRANSFER, copies));
            // SAFETY: both are the device's and hold the region.
            unsafe {
                device.cmd_copy_buffer(commands, from.buffer(), to.buffer(), &regions);
            }
            barrier(
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
pub(super) fn uploaded(device: &ash::Device, commands: vk::CommandBuffer) {
    let uses = Access::SHADER_READ | Access::SHADER_WRITE | Access::UNIFORM_READ;
    let before = (Stages::TRANSFER, Access::TRANSFER_WRITE);
    barrier(device, commands, before, (Stages::COMPUTE_SHADER, uses));
}

/// Records a barrier, while the command buffer is being recorded.
fn barrier(
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
