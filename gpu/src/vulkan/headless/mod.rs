//! Vulkan without an engine: finds a device, allocates, submits and waits. For tests, examples and
//! tools.

mod batch;
mod device;
mod instance;
mod memory;

pub use batch::VulkanBatch;
pub use device::{Commands, Device, devices};
pub use memory::Memory;
