//! The runtime's stages on GPUs: through wgpu, through raw Vulkan, or through the host's own API.
//!
//! The host owns devices, queues, buffers and command encoders. This crate computes the sizes of
//! buffers, makes pipelines, and records dispatches. This crate never submits, never waits, and
//! allocates nothing without the host's knowledge. The modules named `headless` do allocate, submit
//! and wait; they serve tests, examples and tools without an engine.
#![deny(unsafe_code)]

#[cfg(feature = "headless")]
pub mod headless;
pub mod layout;
#[cfg(feature = "vulkan")]
pub mod vulkan;
#[cfg(feature = "wgpu")]
pub mod wgpu;
