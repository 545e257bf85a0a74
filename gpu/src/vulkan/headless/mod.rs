//! Vulkan without an engine: finds a device, allocates, submits and waits. For tests, examples and
//! tools.

mod commands;
mod device;
mod held;
mod instance;
mod memory;
mod messages;
mod uploaded;

pub use commands::Commands;
pub use device::{Device, devices};
pub use memory::Memory;
pub use uploaded::VulkanBatch;

use super::Error;
use crate::headless::HeadlessError;
use ash::vk;

/// Returns what makes an error of a result.
fn while_doing(doing: &'static str) -> impl Fn(vk::Result) -> HeadlessError {
    move |result| match result {
        vk::Result::ERROR_DEVICE_LOST => HeadlessError::Lost(doing.to_owned()),
        _ => HeadlessError::Refused { doing, detail: result.to_string() },
    }
}

impl From<Error> for HeadlessError {
    fn from(error: Error) -> Self {
        match error {
            Error::Layout(error) => Self::Layout(error),
            Error::Vulkan { doing, result } => while_doing(doing)(result),
            Error::NoPipeline { .. } | Error::NotPlanned { .. } | Error::Sets { .. } => {
                Self::Refused { doing: "preparing or recording a batch", detail: error.to_string() }
            }
        }
    }
}
