//! Tests of the GPU paths.
#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

#[path = "../../runtime/tests/allocator.rs"]
mod allocator;
mod common;
mod layout;
mod vulkan;
mod wgpu;
