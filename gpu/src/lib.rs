//! The runtime's stages on GPUs: through wgpu, through raw Vulkan, or through an API of the host's own.
//!
//! The host owns devices, queues, buffers and command encoders. This crate says how large buffers
//! must be, makes pipelines, and records dispatches: it never submits, never waits, and allocates
//! nothing behind the host's back. The helpers named `headless`, which do, are for tests, examples
//! and tools without an engine.
#![deny(unsafe_code)]

#[cfg(feature = "headless")]
pub mod headless;
pub mod layout;
#[cfg(feature = "vulkan")]
pub mod vulkan;
#[cfg(feature = "wgpu")]
pub mod wgpu;
