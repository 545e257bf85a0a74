//! The errors of preparing and recording a batch.

use crate::layout::{LayoutError, Stage};
use ash::vk;
use thiserror::Error;

/// A mistake in the host's call, or an error of the host's Vulkan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Error {
    /// The instances or the buffers do not fit the plan.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// The pipelines lack a stage of the plan.
    #[error("no pipeline of the stage {}", .stage.name())]
    NoPipeline {
        /// The stage.
        stage: Stage,
    },
    /// The plan lacks the stage that was to be recorded.
    #[error("the plan has no stage {}", .stage.name())]
    NotPlanned {
        /// The stage.
        stage: Stage,
    },
    /// The number of descriptor sets does not fit the plan.
    #[error("{found} descriptor sets, expected {expected}")]
    Sets {
        /// Sets that the plan needs: one for each stage and chunk.
        expected: usize,
        /// Sets that the host passed.
        found: usize,
    },
    /// A Vulkan call failed.
    #[error("{doing}: {result}")]
    Vulkan {
        /// The step that failed.
        doing: &'static str,
        /// Vulkan's result.
        result: vk::Result,
    },
}

impl Error {
    /// Returns a function that converts a result of the step `doing` into an error.
    pub(super) fn while_doing(doing: &'static str) -> impl Fn(vk::Result) -> Self {
        move |result| Self::Vulkan { doing, result }
    }
}
