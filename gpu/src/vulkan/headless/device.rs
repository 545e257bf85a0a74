//! A device that has been opened, its queue and its pipelines.

use super::instance::Vulkan;
use super::uploaded::VulkanBatch;
use super::while_doing;
use crate::headless::{Device, DeviceInfo, HeadlessError, Uploaded};
use crate::layout::{DeviceLimits, Plan, Stage};
use crate::vulkan::{Pipelines, limits};
use ash::vk;
use sinew_runtime::Model;
use std::mem::take;

/// A device, opened without any feature, with the pipelines of every stage.
pub struct Headless {
    pub(super) device: ash::Device,
    pub(super) memory: vk::PhysicalDeviceMemoryProperties,
    pipelines: Pipelines,
    physical: vk::PhysicalDevice,
    queue: vk::Queue,
    family: u32,
    commands: vk::CommandPool,
    info: DeviceInfo,
    limits: DeviceLimits,
    vulkan: Vulkan,
}

impl Headless {
    /// Lists the devices that there are.
    ///
    /// # Errors
    /// - [`HeadlessError::Missing`]: no loader, or no driver.
    /// - [`HeadlessError::Refused`]
    pub fn list() -> Result<Vec<DeviceInfo>, HeadlessError> {
        let devices = Vulkan::new(false)?.devices()?;
        Ok(devices.into_iter().map(|(_, info)| info).collect())
    }

    /// Opens the first device whose driver, or else name, contains a text, in whatever case; without
    /// one the first that is hardware, or else the first. Validation turns the Khronos layer on,
    /// synchronisation included.
    ///
    /// # Errors
    /// - [`HeadlessError::Missing`]: no loader, no driver, or no layer where validation is asked for.
    /// - [`HeadlessError::NoDevice`]
    /// - [`HeadlessError::Refused`]
    pub fn open(wanted: Option<&str>, validation: bool) -> Result<Self, HeadlessError> {
        let vulkan = Vulkan::new(validation)?;
        let (physical, info) = choose(vulkan.devices()?, wanted)?;
        // SAFETY: the device is this instance's.
        let families =
            unsafe { vulkan.instance.get_physical_device_queue_family_properties(physical) };
        let compute =
            |own: &vk::QueueFamilyProperties| own.queue_flags.contains(vk::QueueFlags::COMPUTE);
        let family = families.iter().position(compute).ok_or_else(|| HeadlessError::Refused {
            doing: "choosing a queue",
            detail: "no family has compute".to_owned(),
        })? as u32;
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(family)
            .queue_priorities(&[1.0])];
        let create = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
        // SAFETY: the family is the device's, and what is pointed to lives through the call.
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
        // Whoever drops it has it freed, from here on.
        let mut headless = Self {
            // SAFETY: the device has one queue of this family.
            queue: unsafe { device.get_device_queue(family, 0) },
            device,
            memory,
            pipelines: Pipelines::default(),
            physical,
            family,
            commands: vk::CommandPool::null(),
            info,
            limits: at_most(real, DeviceLimits::DOWNLEVEL),
            vulkan,
        };
        let create = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER)
            .queue_family_index(family);
        // SAFETY: likewise.
        headless.commands = unsafe { headless.device.create_command_pool(&create, None) }
            .map_err(while_doing("making a command pool"))?;
        let cache = vk::PipelineCache::null();
        // SAFETY: the device is valid.
        headless.pipelines = unsafe { Pipelines::new(&headless.device, &Stage::ALL, cache, None) }?;
        Ok(headless)
    }

    /// Returns the device.
    pub fn device(&self) -> &ash::Device {
        &self.device
    }

    /// Returns the instance and the physical device.
    pub fn physical(&self) -> (&ash::Instance, vk::PhysicalDevice) {
        (&self.vulkan.instance, self.physical)
    }

    /// Returns the queue and its family.
    pub fn queue(&self) -> (vk::Queue, u32) {
        (self.queue, self.family)
    }

    /// Returns the pipelines.
    pub fn pipelines(&self) -> &Pipelines {
        &self.pipelines
    }

    /// Lists the validation layers' messages so far; `None` without validation.
    pub fn messages(&self) -> Option<Vec<String>> {
        self.vulkan.messages()
    }

    /// Allocates the buffers of a batch: [`Device::upload`] with a type that shows more.
    ///
    /// # Errors
    /// [`HeadlessError`]
    pub fn batch(&self, model: &Model<'_>, plan: &Plan) -> Result<VulkanBatch<'_>, HeadlessError> {
        VulkanBatch::new(self, model, plan)
    }

    /// Allocates a command buffer that can be recorded again and again; the device frees it.
    ///
    /// # Errors
    /// [`HeadlessError`]
    pub fn command_buffer(&self) -> Result<vk::CommandBuffer, HeadlessError> {
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(self.commands)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: the pool is this device's.
        let buffers = unsafe { self.device.allocate_command_buffers(&info) }
            .map_err(while_doing("allocating a command buffer"))?;
        Ok(buffers.first().copied().unwrap_or_default())
    }

    /// Records into a command buffer, submits it, and waits.
    ///
    /// # Errors
    /// [`HeadlessError`]; nothing is submitted where `record` fails.
    ///
    /// # Safety
    /// The command buffer must be of [`Headless::command_buffer`] and not be in use, and what is
    /// recorded must be valid.
    pub unsafe fn submit(
        &self,
        command_buffer: vk::CommandBuffer,
        record: impl FnOnce(&ash::Device) -> Result<(), HeadlessError>,
    ) -> Result<(), HeadlessError> {
        let begin = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: as our own caller promises.
        unsafe { self.device.begin_command_buffer(command_buffer, &begin) }
            .map_err(while_doing("beginning a command buffer"))?;
        let recorded = record(&self.device);
        // SAFETY: it has been begun.
        unsafe { self.device.end_command_buffer(command_buffer) }
            .map_err(while_doing("ending a command buffer"))?;
        recorded?;
        let buffers = [command_buffer];
        let submits = [vk::SubmitInfo::default().command_buffers(&buffers)];
        // SAFETY: as our own caller promises; the queue is ours alone.
        unsafe {
            self.device
                .queue_submit(self.queue, &submits, vk::Fence::null())
                .map_err(while_doing("submitting"))?;
            self.device.queue_wait_idle(self.queue).map_err(while_doing("waiting"))
        }
    }

    pub(super) fn free_command_buffer(&self, command_buffer: vk::CommandBuffer) {
        // SAFETY: it comes from this pool, and whatever was submitted has been waited for.
        unsafe { self.device.free_command_buffers(self.commands, &[command_buffer]) };
    }
}

impl Device for Headless {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn limits(&self) -> DeviceLimits {
        self.limits
    }

    fn upload(
        &self,
        model: &Model<'_>,
        plan: &Plan,
    ) -> Result<Box<dyn Uploaded + '_>, HeadlessError> {
        Ok(Box::new(self.batch(model, plan)?))
    }

    fn message_len(&self) -> Option<usize> {
        self.messages().map(|messages| messages.len())
    }
}

impl Drop for Headless {
    fn drop(&mut self) {
        // SAFETY: batches borrow this and are gone; whatever was submitted has been waited for.
        unsafe {
            take(&mut self.pipelines).destroy(&self.device, None);
            self.device.destroy_command_pool(self.commands, None);
            self.device.destroy_device(None);
        }
    }
}

fn choose(
    devices: Vec<(vk::PhysicalDevice, DeviceInfo)>,
    wanted: Option<&str>,
) -> Result<(vk::PhysicalDevice, DeviceInfo), HeadlessError> {
    let index = match wanted {
        None => devices.iter().position(|(_, info)| !info.software).or(Some(0)),
        Some(wanted) => {
            let wanted = wanted.to_lowercase();
            let has = |text: &str| text.to_lowercase().contains(&wanted);
            let of_driver = devices.iter().position(|(_, info)| has(&info.driver));
            of_driver.or_else(|| devices.iter().position(|(_, info)| has(&info.name)))
        }
    };
    let found = devices.iter().map(|(_, info)| info.driver.clone()).collect();
    let chosen = index.and_then(|index| devices.into_iter().nth(index));
    chosen.ok_or_else(|| HeadlessError::NoDevice {
        api: "vulkan",
        wanted: wanted.unwrap_or("of any kind").to_owned(),
        found,
    })
}

/// Returns a device's limits, but none beyond another's.
fn at_most(own: DeviceLimits, other: DeviceLimits) -> DeviceLimits {
    DeviceLimits {
        storage_binding_bytes: own.storage_binding_bytes.min(other.storage_binding_bytes),
        storage_buffers: own.storage_buffers.min(other.storage_buffers),
        offset_alignment: own.offset_alignment.max(other.offset_alignment),
        workgroup_threads: own.workgroup_threads.min(other.workgroup_threads),
        groups: own.groups.min(other.groups),
    }
}
