//! Vulkan without an engine: finds a device, allocates, submits and waits. For tests, examples and
//! tools.

mod commands;
mod device;
mod error;
mod held;
mod instance;
mod memory;
mod messages;
mod uploaded;

pub use commands::Commands;
pub use device::{Device, devices};
pub use memory::Memory;
pub use uploaded::VulkanBatch;
