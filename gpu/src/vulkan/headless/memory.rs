//! Buffers, each with its own memory.

use super::device::Device;
use super::instance::while_doing;
use crate::headless::{HeadlessError, refused};
use ash::vk::{self, MemoryPropertyFlags as Flags};

/// A buffer with its memory, freed when dropped. Commands that use the buffer must have been waited
/// for.
pub struct Memory<'d> {
    device: &'d Device,
    buffer: vk::Buffer,
    memory: vk::DeviceMemory,
    bytes: u64,
    mapped: Option<*mut u8>,
}

impl<'d> Memory<'d> {
    /// Allocates a buffer in the device's own memory, which can be copied to and from.
    ///
    /// # Errors
    /// [`HeadlessError`]
    pub fn local(
        device: &'d Device,
        bytes: u64,
        usage: vk::BufferUsageFlags,
    ) -> Result<Self, HeadlessError> {
        Self::new(device, bytes, usage, Flags::DEVICE_LOCAL, Flags::DEVICE_LOCAL)
    }

    /// Allocates a buffer in host-visible memory, cached if the device has such memory. The buffer
    /// can be copied to and from.
    ///
    /// # Errors
    /// [`HeadlessError`]
    pub fn staging(
        device: &'d Device,
        bytes: u64,
        usage: vk::BufferUsageFlags,
    ) -> Result<Self, HeadlessError> {
        let visible = Flags::HOST_VISIBLE | Flags::HOST_COHERENT;
        let mut own = Self::new(device, bytes, usage, visible | Flags::HOST_CACHED, visible)?;
        let (whole, none) = (vk::WHOLE_SIZE, vk::MemoryMapFlags::empty());
        // SAFETY: the memory is host-visible and not mapped yet.
        let mapped = unsafe { device.device().map_memory(own.memory, 0, whole, none) }
            .map_err(while_doing("mapping memory"))?;
        own.mapped = Some(mapped.cast());
        Ok(own)
    }

    /// Returns the buffer.
    pub fn buffer(&self) -> vk::Buffer {
        self.buffer
    }

    /// Returns the length of the buffer in bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Copies bytes into host-visible memory, from its start.
    ///
    /// # Errors
    /// [`HeadlessError::Refused`]: the memory is not host-visible, or is shorter.
    pub fn fill(&mut self, bytes: &[u8]) -> Result<(), HeadlessError> {
        let to = self.host_pointer(bytes.len(), "writing to memory")?;
        // SAFETY: enough bytes are mapped, and no command in flight uses them.
        unsafe { to.copy_from_nonoverlapping(bytes.as_ptr(), bytes.len()) };
        Ok(())
    }

    /// Copies bytes out of host-visible memory, from its start.
    ///
    /// # Errors
    /// [`HeadlessError::Refused`]: the memory is not host-visible, or is shorter.
    pub fn copy(&self, out: &mut [u8]) -> Result<(), HeadlessError> {
        let from = self.host_pointer(out.len(), "reading memory")?;
        // SAFETY: as in `fill`.
        unsafe { from.copy_to_nonoverlapping(out.as_mut_ptr(), out.len()) };
        Ok(())
    }

    fn host_pointer(&self, bytes: usize, doing: &'static str) -> Result<*mut u8, HeadlessError> {
        if bytes as u64 > self.bytes {
            return Err(refused(doing)("more bytes than there are"));
        }
        self.mapped.ok_or_else(|| refused(doing)("the host does not see it"))
    }

    /// Allocates a buffer that can be copied to and from, and memory with the `wanted` flags, or at
    /// least with the `needed` flags.
    fn new(
        device: &'d Device,
        bytes: u64,
        usage: vk::BufferUsageFlags,
        wanted: Flags,
        needed: Flags,
    ) -> Result<Self, HeadlessError> {
        let raw = device.device();
        let copied = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage | copied);
        // SAFETY: the device is valid, here and below. A drop frees the objects made so far.
        let buffer =
            unsafe { raw.create_buffer(&info, None) }.map_err(while_doing("making a buffer"))?;
        let memory = vk::DeviceMemory::null();
        let mut own = Self { device, buffer, memory, bytes, mapped: None };
        // SAFETY: the buffer has just been made on this device.
        let asked = unsafe { raw.get_buffer_memory_requirements(buffer) };
        let kind = |flags: Flags| {
            let types = device.memory.memory_types_as_slice().iter().zip(0..);
            let mut fitting = types.filter(|(kind, index)| {
                asked.memory_type_bits >> index & 1 == 1 && kind.property_flags.contains(flags)
            });
            fitting.next().map(|(_, index)| index)
        };
        let kind = kind(wanted).or_else(|| kind(needed));
        let kind = kind.ok_or_else(|| refused("choosing memory")("no type of memory serves"))?;
        let info =
            vk::MemoryAllocateInfo::default().allocation_size(asked.size).memory_type_index(kind);
        // SAFETY: the memory type belongs to the device.
        own.memory = unsafe { raw.allocate_memory(&info, None) }
            .map_err(while_doing("allocating memory"))?;
        // SAFETY: both have just been made, and the memory is as long as the buffer requires.
        unsafe { raw.bind_buffer_memory(buffer, own.memory, 0) }
            .map_err(while_doing("binding memory"))?;
        Ok(own)
    }
}

impl Drop for Memory<'_> {
    fn drop(&mut self) {
        let device = self.device.device();
        // SAFETY: commands that use the buffer have been waited for; freeing unmaps the memory.
        unsafe {
            device.destroy_buffer(self.buffer, None);
            device.free_memory(self.memory, None);
        }
    }
}
