//! An open device, its queue, its pipelines, and its command buffers.

use super::super::pipelines::{Pipelines, limits};
use super::instance::{Vulkan, while_doing};
use crate::headless::{DeviceInfo, HeadlessError, refused};
use crate::layout::{DeviceLimits, Stage};
use ash::vk;
use std::cell::Cell;
use std::marker::PhantomData;
use std::mem::take;

/// Lists the devices of the machine.
///
/// # Errors
/// - [`HeadlessError::Missing`]: no loader, or no driver.
/// - [`HeadlessError::Refused`]
pub fn devices() -> Result<Vec<DeviceInfo>, HeadlessError> {
    let devices = Vulkan::new(false)?.devices()?;
    Ok(devices.into_iter().map(|(_, info)| info).collect())
}

/// An open device without optional features, with the pipelines of every stage.
pub struct Device {
    device: ash::Device,
    pub(super) memory: vk::PhysicalDeviceMemoryProperties,
    pipelines: Pipelines,
    physical: vk::PhysicalDevice,
    queue: vk::Queue,
    commands: vk::CommandPool,
    pub(super) info: DeviceInfo,
    pub(super) limits: DeviceLimits,
    vulkan: Vulkan,
    /// Only one thread at a time may use the command pool and the queue.
    _not_sync: PhantomData<Cell<()>>,
}

impl Device {
    /// Opens the first device that `wanted` accepts; `name` describes the request in words.
    /// `validation` turns on the Khronos layer, with synchronisation validation.
    ///
    /// # Errors
    /// - [`HeadlessError::Missing`]: no loader, no driver, or no layer although validation is
    ///   requested.
    /// - [`HeadlessError::NoDevice`]
    /// - [`HeadlessError::Refused`]: the device cannot be opened.
    pub fn open(
        wanted: impl Fn(&DeviceInfo) -> bool,
        name: &str,
        validation: bool,
    ) -> Result<Self, HeadlessError> {
        let vulkan = Vulkan::new(validation)?;
        let devices = vulkan.devices()?;
        let found = devices.iter().map(|(_, info)| info.driver.clone()).collect();
        let own = devices.into_iter().find(|(_, info)| wanted(info));
        let Some((physical, info)) = own else {
            return Err(HeadlessError::NoDevice { api: "vulkan", wanted: name.to_owned(), found });
        };
        // SAFETY: the device belongs to this instance.
        let families =
            unsafe { vulkan.instance.get_physical_device_queue_family_properties(physical) };
        let compute =
            |own: &vk::QueueFamilyProperties| own.queue_flags.contains(vk::QueueFlags::COMPUTE);
        let family = families.iter().position(compute);
        let family = family.ok_or_else(|| refused("choosing a queue")("no family has compute"))?;
        let family = family as u32;
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(family)
            .queue_priorities(&[1.0])];
        let create = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
        // SAFETY: the family belongs to the device, and all pointers live through the call.
        let device = unsafe { vulkan.instance.create_device(physical, &create, None) }
            .map_err(while_doing("opening the device"))?;
        // SAFETY: the device is valid.
        let (properties, memory) = unsafe {
            (
                vulkan.instance.get_physical_device_properties(physical),
                vulkan.instance.get_physical_device_memory_properties(physical),
            )
        };
        let real = limits(&properties.limits);
        // From here on, a drop frees everything.
        let mut own = Self {
            // SAFETY: the device has one queue of this family.
            queue: unsafe { device.get_device_queue(family, 0) },
            device,
            memory,
            pipelines: Pipelines::default(),
            physical,
            commands: vk::CommandPool::null(),
            info,
            limits: at_most(real, DeviceLimits::DOWNLEVEL),
            vulkan,
            _not_sync: PhantomData,
        };
        let create = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER)
            .queue_family_index(family);
        // SAFETY: as above.
        own.commands = unsafe { own.device.create_command_pool(&create, None) }
            .map_err(while_doing("making a command pool"))?;
        let cache = vk::PipelineCache::null();
        // SAFETY: the device is valid.
        own.pipelines = unsafe { Pipelines::new(&own.device, &Stage::ALL, cache, None) }?;
        Ok(own)
    }

    /// Opens the first device of a driver, by [`DeviceInfo::driver`].
    ///
    /// # Errors
    /// As for [`Device::open`].
    pub fn of_driver(driver: &str, validation: bool) -> Result<Self, HeadlessError> {
        Self::open(|info| info.driver == driver, driver, validation)
    }

    /// Returns the device.
    pub fn device(&self) -> &ash::Device {
        &self.device
    }

    /// Returns the instance and the physical device.
    pub fn physical(&self) -> (&ash::Instance, vk::PhysicalDevice) {
        (&self.vulkan.instance, self.physical)
    }

    /// Returns the pipelines.
    pub fn pipelines(&self) -> &Pipelines {
        &self.pipelines
    }

    /// Lists the validation layers' messages so far; `None` without validation.
    pub fn messages(&self) -> Option<Vec<String>> {
        self.vulkan.messages()
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: batches borrow this and are gone; all submissions have been waited for.
        unsafe {
            take(&mut self.pipelines).destroy(&self.device, None);
            self.device.destroy_command_pool(self.commands, None);
            self.device.destroy_device(None);
        }
    }
}

/// A command buffer that can be recorded repeatedly; freed when dropped.
pub struct Commands<'d> {
    device: &'d Device,
    raw: vk::CommandBuffer,
}

impl<'d> Commands<'d> {
    /// Allocates a command buffer.
    ///
    /// # Errors
    /// [`HeadlessError`]
    pub fn new(device: &'d Device) -> Result<Self, HeadlessError> {
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(device.commands)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: the pool belongs to this device.
        let buffers = unsafe { device.device().allocate_command_buffers(&info) }
            .map_err(while_doing("allocating a command buffer"))?;
        Ok(Self { device, raw: buffers.first().copied().unwrap_or_default() })
    }

    /// Records, submits, and waits for completion.
    ///
    /// # Errors
    /// [`HeadlessError`]; if `record` fails, nothing is submitted.
    ///
    /// # Safety
    /// `record` must record valid commands.
    pub unsafe fn submit(
        &self,
        record: impl FnOnce(&ash::Device, vk::CommandBuffer) -> Result<(), HeadlessError>,
    ) -> Result<(), HeadlessError> {
        let device = self.device.device();
        let begin = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the command buffer is not in flight, and its pool allows a reset.
        unsafe { device.begin_command_buffer(self.raw, &begin) }
            .map_err(while_doing("beginning a command buffer"))?;
        let recorded = record(device, self.raw);
        // SAFETY: the command buffer has been begun.
        unsafe { device.end_command_buffer(self.raw) }
            .map_err(while_doing("ending a command buffer"))?;
        recorded?;
        let (queue, buffers) = (self.device.queue, [self.raw]);
        let submits = [vk::SubmitInfo::default().command_buffers(&buffers)];
        // SAFETY: as our own caller promises; the device, and so the queue, is used by one thread.
        unsafe {
            device
                .queue_submit(queue, &submits, vk::Fence::null())
                .map_err(while_doing("submitting"))?;
            device.queue_wait_idle(queue).map_err(while_doing("waiting"))
        }
    }
}

impl Drop for Commands<'_> {
    fn drop(&mut self) {
        let device = self.device.device();
        // SAFETY: the command buffer comes from this pool, and all submissions have been waited
        // for.
        unsafe { device.free_command_buffers(self.device.commands, &[self.raw]) };
    }
}

/// Returns the stricter of two devices' limits, limit by limit.
fn at_most(own: DeviceLimits, other: DeviceLimits) -> DeviceLimits {
    DeviceLimits {
        storage_binding_bytes: own.storage_binding_bytes.min(other.storage_binding_bytes),
        storage_buffers: own.storage_buffers.min(other.storage_buffers),
        offset_alignment: own.offset_alignment.max(other.offset_alignment),
        workgroup_threads: own.workgroup_threads.min(other.workgroup_threads),
        workgroups: own.workgroups.min(other.workgroups),
    }
}
