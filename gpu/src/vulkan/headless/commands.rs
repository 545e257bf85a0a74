//! A command buffer that is recorded, submitted, and waited for.

use super::device::Device;
use super::error::while_doing;
use crate::headless::HeadlessError;
use ash::vk;

/// A command buffer that can be recorded again and again; freed when dropped.
pub struct Commands<'d> {
    device: &'d Device,
    raw: vk::CommandBuffer,
}

impl<'d> Commands<'d> {
    /// Allocates it.
    ///
    /// # Errors
    /// [`HeadlessError`]
    pub fn new(device: &'d Device) -> Result<Self, HeadlessError> {
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(device.commands)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: the pool is this device's.
        let buffers = unsafe { device.device().allocate_command_buffers(&info) }
            .map_err(while_doing("allocating a command buffer"))?;
        Ok(Self { device, raw: buffers.first().copied().unwrap_or_default() })
    }

    /// Records, submits, and waits: nothing of it is in flight afterwards.
    ///
    /// # Errors
    /// [`HeadlessError`]; where `record` fails, nothing is submitted.
    ///
    /// # Safety
    /// What is recorded must be valid.
    pub unsafe fn submit(
        &self,
        record: impl FnOnce(&ash::Device, vk::CommandBuffer) -> Result<(), HeadlessError>,
    ) -> Result<(), HeadlessError> {
        let device = self.device.device();
        let begin = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: it is not in flight, and its pool lets it be reset.
        unsafe { device.begin_command_buffer(self.raw, &begin) }
            .map_err(while_doing("beginning a command buffer"))?;
        let recorded = record(device, self.raw);
        // SAFETY: it has been begun.
        unsafe { device.end_command_buffer(self.raw) }
            .map_err(while_doing("ending a command buffer"))?;
        recorded?;
        let (queue, buffers) = (self.device.queue().0, [self.raw]);
        let submits = [vk::SubmitInfo::default().command_buffers(&buffers)];
        // SAFETY: as our own caller promises; the queue is one thread's, as the device is.
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
        // SAFETY: it comes from this pool, and whatever was submitted has been waited for.
        unsafe { device.free_command_buffers(self.device.commands, &[self.raw]) };
    }
}
