//! Buffers, each with memory of its own.

use super::device::Device;
use super::instance::while_doing;
use crate::headless::HeadlessError;
use ash::vk::{self, MemoryPropertyFlags as Flags};

/// A buffer with its memory, freed when dropped: what used it must have been waited for.
pub struct Memory<'d> {
    device: &'d Device,
    buffer: vk::Buffer,
    memory: vk::DeviceMemory,
    bytes: u64,
    mapped: Option<*mut u8>,
}

impl<'d> Memory<'d> {
    /// Allocates a buffer in the device's own memory, which may be copied to and from.
    ///
    /// # Errors
    /// [`HeadlessError`]
    pub fn local(
        device: &'d Device,
        bytes: u64,
        usage: vk::BufferUsageFlags,
    ) -> Result<Self, HeadlessError> {
        let copied = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        Self::new(device, bytes, usage | copied, Flags::DEVICE_LOCAL, Flags::DEVICE_LOCAL)
    }

    /// Allocates a buffer that the host sees, cached where there is such memory; it may be copied to
    /// and from.
    ///
    /// # Errors
    /// [`HeadlessError`]
    pub fn staging(
        device: &'d Device,
        bytes: u64,
        usage: vk::BufferUsageFlags,
    ) -> Result<Self, HeadlessError> {
        let copied = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        let seen = Flags::HOST_VISIBLE | Flags::HOST_COHERENT;
        let mut own = Self::new(device, bytes, usage | copied, seen | Flags::HOST_CACHED, seen)?;
        let (whole, none) = (vk::WHOLE_SIZE, vk::MemoryMapFlags::empty());
        // SAFETY: the memory is the host's to see, and is not mapped.
        let mapped = unsafe { device.device().map_memory(own.memory, 0, whole, none) }
            .map_err(while_doing("mapping memory"))?;
        own.mapped = Some(mapped.cast());
        Ok(own)
    }

    /// Returns the buffer.
    pub fn buffer(&self) -> vk::Buffer {
        self.buffer
    }

    /// Returns how many bytes it has.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Copies bytes into what the host sees, from its start on.
    ///
    /// # Errors
    /// [`HeadlessError::Refused`]: it is not the host's to see, or shorter.
    pub fn fill(&mut self, bytes: &[u8]) -> Result<(), HeadlessError> {
        let to = self.seen(bytes.len(), "writing to memory")?;
        // SAFETY: so many bytes are mapped, and no command in flight uses them: all are waited for.
        unsafe { to.copy_from_nonoverlapping(bytes.as_ptr(), bytes.len()) };
        Ok(())
    }

    /// Copies bytes out of what the host sees, from its start on.
    ///
    /// # Errors
    /// [`HeadlessError::Refused`]: it is not the host's to see, or shorter.
    pub fn copy(&self, out: &mut [u8]) -> Result<(), HeadlessError> {
        let from = self.seen(out.len(), "reading memory")?;
        // SAFETY: as in `fill`.
        unsafe { from.copy_to_nonoverlapping(out.as_mut_ptr(), out.len()) };
        Ok(())
    }

    fn seen(&self, bytes: usize, doing: &'static str) -> Result<*mut u8, HeadlessError> {
        let refused = |detail: &str| HeadlessError::Refused { doing, detail: detail.to_owned() };
        if bytes as u64 > self.bytes {
            return Err(refused("more bytes than there are"));
        }
        self.mapped.ok_or_else(|| refused("the host does not see it"))
    }

    /// Allocates memory that has the wanted flags, or at least the needed ones.
    fn new(
        device: &'d Device,
        bytes: u64,
        usage: vk::BufferUsageFlags,
        wanted: Flags,
        needed: Flags,
    ) -> Result<Self, HeadlessError> {
        let raw = device.device();
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage);
        // SAFETY: the device is valid; so below. A drop frees what has been made so far.
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
        let kind = kind(wanted).or_else(|| kind(needed)).ok_or_else(|| HeadlessError::Refused {
            doing: "choosing memory",
            detail: "no type of memory serves".to_owned(),
        })?;
        let info =
            vk::MemoryAllocateInfo::default().allocation_size(asked.size).memory_type_index(kind);
        // SAFETY: the type is the device's.
        own.memory = unsafe { raw.allocate_memory(&info, None) }
            .map_err(while_doing("allocating memory"))?;
        // SAFETY: both have just been made, and the memory is as long as the buffer asks.
        unsafe { raw.bind_buffer_memory(buffer, own.memory, 0) }
            .map_err(while_doing("binding memory"))?;
        Ok(own)
    }
}

impl Drop for Memory<'_> {
    fn drop(&mut self) {
        let device = self.device.device();
        // SAFETY: whatever used it has been waited for; memory that is freed is unmapped.
        unsafe {
            device.destroy_buffer(self.buffer, None);
            device.free_memory(self.memory, None);
        }
    }
}
