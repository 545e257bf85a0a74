//! The errors of preparing and encoding a batch.

use crate::layout::{LayoutError, Resource, Stage};
use ::wgpu::{Backend, BufferUsages, Device, ErrorFilter};
use std::pin::pin;
use std::task::{Context, Poll, Waker};
use thiserror::Error;

/// Reasons why nothing was made or recorded.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Error {
    /// The batch, the device's limits or a span do not fit.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// A buffer lacks a usage that its resource needs.
    #[error("{} has usages {found:?}, expected {expected:?} among them", .resource.name())]
    Usage {
        /// The resource.
        resource: Resource,
        /// The required usage.
        expected: BufferUsages,
        /// The buffer's usages.
        found: BufferUsages,
    },
    /// Two resources share a buffer, and a stage writes one while it reads the other. wgpu tracks
    /// uses of whole buffers, and forbids this.
    #[error("{} is written and {} read by {}, in one buffer", .written.name(), .read.name(), .stage.name())]
    Shared {
        /// The stage.
        stage: Stage,
        /// The resource that the stage writes.
        written: Resource,
        /// The resource that the stage reads.
        read: Resource,
    },
    /// The pipelines lack a stage of the plan.
    #[error("no pipeline of {}", .stage.name())]
    NoPipeline {
        /// The stage.
        stage: Stage,
    },
    /// The plan lacks the requested stage.
    #[error("{} is no stage of this batch", .stage.name())]
    NotPlanned {
        /// The stage.
        stage: Stage,
    },
    /// The device is out of memory.
    #[error("out of memory while making {making}")]
    OutOfMemory {
        /// The object that was being made.
        making: &'static str,
    },
    /// The device refuses an object: a shader that fails to compile, or a buffer of another device.
    #[error("{making}: {detail}")]
    Refused {
        /// The object that was being made.
        making: &'static str,
        /// wgpu's message.
        detail: String,
    },
}

/// Makes objects, and returns the error that the device reports. Native devices report at once, so
/// this function never waits. A browser reports later, so errors there reach only the browser's own
/// error scopes and handlers. Device loss reaches only the host's callback; objects that a lost
/// device makes are void.
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
    // Scopes close in reverse order; the first one with an error returns it.
    let found = [ready(validation.pop()), ready(internal.pop()), ready(memory.pop())];
    match found.into_iter().flatten().flatten().next() {
        None => Ok(made),
        Some(::wgpu::Error::OutOfMemory { .. }) => Err(Error::OutOfMemory { making }),
        Some(error) => Err(Error::Refused { making, detail: error.to_string() }),
    }
}

/// Polls a future once; `None` if it is not ready.
fn ready<T>(future: impl Future<Output = T>) -> Option<T> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => Some(value),
        Poll::Pending => None,
    }
}
