//! The helper's errors, made of Vulkan's and of the stages'.

use super::super::error::Error;
use crate::headless::HeadlessError;
use ash::vk;

/// Makes a function that turns a result into an error.
pub(super) fn while_doing(doing: &'static str) -> impl Fn(vk::Result) -> HeadlessError {
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
