//! What can go wrong before anything is recorded.

use crate::layout::{LayoutError, Stage};
use ash::vk;
use thiserror::Error;

/// A call that the host has wrong, or that its Vulkan refuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Error {
    /// Instances or buffers do not suit the plan.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// A stage is needed whose pipeline was not asked for.
    #[error("no pipeline of the stage {}", .stage.name())]
    NoPipeline {
        /// The stage.
        stage: Stage,
    },
    /// A stage is to be recorded that the plan does not have.
    #[error("the plan has no stage {}", .stage.name())]
    NotPlanned {
        /// The stage.
        stage: Stage,
    },
    /// The number of descriptor sets is not the plan's.
    #[error("{found} descriptor sets, expected {expected}")]
    Sets {
        /// One a stage and chunk.
        expected: usize,
        /// Sets given.
        found: usize,
    },
    /// Vulkan refuses.
    #[error("{doing}: {result}")]
    Vulkan {
        /// What was being done.
        doing: &'static str,
        /// What it says.
        result: vk::Result,
    },
}

impl Error {
    /// Makes a function that turns a result into an error.
    pub(super) fn while_doing(doing: &'static str) -> impl Fn(vk::Result) -> Self {
        move |result| Self::Vulkan { doing, result }
    }
}
