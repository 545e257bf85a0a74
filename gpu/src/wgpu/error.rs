//! What can be wrong with a device, with the host's buffers, or with a call.

use crate::layout::{LayoutError, Resource, Stage};
use ::wgpu::{Backend, BufferUsages, Device, ErrorFilter};
use std::pin::pin;
use std::task::{Context, Poll, Waker};
use thiserror::Error;

/// Why nothing was made, or nothing recorded.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Error {
    /// The batch, the device's limits or a span do not fit.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// A buffer was made without a usage that it needs.
    #[error("{} has usages {found:?}, expected {expected:?} among them", .resource.name())]
    Usage {
        /// What the buffer is for.
        resource: Resource,
        /// The usage needed.
        expected: BufferUsages,
        /// Its usages.
        found: BufferUsages,
    },
    /// Two resources lie in one buffer, and a stage writes one while it reads the other, which wgpu
    /// tells apart by whole buffers.
    #[error("{} is written and {} read by {}, in one buffer", .written.name(), .read.name(), .stage.name())]
    Shared {
        /// The stage.
        stage: Stage,
        /// What it writes.
        written: Resource,
        /// What it reads.
        read: Resource,
    },
    /// The pipelines were made without a stage that the plan has.
    #[error("no pipeline of {}", .stage.name())]
    NoPipeline {
        /// The stage.
        stage: Stage,
    },
    /// A stage is asked for that the plan does not have.
    #[error("{} is no stage of this batch", .stage.name())]
    NotPlanned {
        /// The stage.
        stage: Stage,
    },
    /// The device has no memory left.
    #[error("out of memory while making {making}")]
    OutOfMemory {
        /// What was being made.
        making: &'static str,
    },
    /// The device refuses: a shader that its compiler does not take, a buffer of another device.
    #[error("{making}: {detail}")]
    Refused {
        /// What was being made.
        making: &'static str,
        /// What wgpu says.
        detail: String,
    },
}

/// Makes objects and returns what the device had against them, without waiting: natively it answers
/// at once. A browser answers later, so there its own error scopes and handlers are left to tell. That
/// a device was lost only the host's callback is told: whatever such a device makes is void.
pub(super) fn scoped<T>(
    device: &Device,
    making: &'static str,
    make: impl FnOnce() -> T,
) -> Result<T, Error> {
    if device.adapter_info().backend == Backend::BrowserWebGpu {
        return Ok(make());
    }
    let memory = device.push_error_scope(ErrorFilter::OutOfMemory);
    let internal = device.push_error_scope(ErrorFilter::Internal);
    let validation = device.push_error_scope(ErrorFilter::Validation);
    let made = make();
    // In reverse order; the first that caught something tells it.
    let found = [ready(validation.pop()), ready(internal.pop()), ready(memory.pop())];
    match found.into_iter().flatten().flatten().next() {
        None => Ok(made),
        Some(::wgpu::Error::OutOfMemory { .. }) => Err(Error::OutOfMemory { making }),
        Some(error) => Err(Error::Refused { making, detail: error.to_string() }),
    }
}

/// Returns what a future has ready.
fn ready<T>(future: impl Future<Output = T>) -> Option<T> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => Some(value),
        Poll::Pending => None,
    }
}
