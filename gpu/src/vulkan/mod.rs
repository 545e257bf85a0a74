//! The stages on the host's own Vulkan 1.0 or later, through ash.
//!
//! This module owns no device memory, and never submits or waits. The order of calls:
//!
//! 1. [`limits`] converts the limits of the physical device for [`Plan::new`].
//! 2. [`Pipelines::new`] makes the pipelines, once for each device.
//! 3. For each batch and each [`Resource`] that has any bytes, the host makes a buffer, or reserves
//!    a part of one, of [`Plan::bytes`] bytes and with [`usage`]. A part starts at a multiple of
//!    [`crate::layout::ALIGNMENT`]. The host uploads [`Plan::params`] and
//!    [`sinew_runtime::Model::blob`].
//! 4. The host makes a descriptor pool with room for [`pool_sizes`] and [`set_len`], and allocates
//!    sets of [`Pipelines::set_layouts`] from the pool. [`Bound::new`] checks the buffers and
//!    writes the sets.
//! 5. Each frame the host writes poses and curves, queries of a kernel, weights of shapes, or
//!    samples. Then the host calls [`Bound::record`], which allocates nothing.
//! 6. At the end the host destroys pool and buffers, and calls [`Pipelines::destroy`].
//!
//! # Barriers of the host
//! The host places two barriers. [`Bound::record`] places the barriers between stages and between
//! two records.
//!
//! Before the record: the blob, the host's input and the frame's poses and curves, queries, weights
//! or samples must be visible to [`vk::PipelineStageFlags::COMPUTE_SHADER`] with
//! [`vk::AccessFlags::SHADER_READ`]. The params must be visible there with
//! [`vk::AccessFlags::UNIFORM_READ`]. Commands that read the palettes, confidences and outputs of
//! the last frame must be done.
//!
//! After the record: vertex input, a vertex shader, or any other user of palettes, confidences and
//! outputs must wait for [`vk::PipelineStageFlags::COMPUTE_SHADER`] with
//! [`vk::AccessFlags::SHADER_WRITE`].
//!
//! ```no_run
//! use ash::vk;
//! use sinew_gpu::layout::{Batch, Plan, Resource};
//! use sinew_gpu::vulkan::{Bound, Buffers, Error, Pipelines, limits, pool_sizes, set_len};
//! use sinew_runtime::{Envelope, Model, Skin};
//!
//! # fn buffer_of(_: Resource, _bytes: u64) -> vk::Buffer { vk::Buffer::null() }
//! # fn vulkan(doing: &'static str) -> impl Fn(vk::Result) -> Error {
//! #     move |result| Error::Vulkan { doing, result }
//! # }
//! /// Prepares the plan that each frame records.
//! unsafe fn prepare(
//!     device: &ash::Device,
//!     properties: &vk::PhysicalDeviceProperties,
//!     model: &Model<Vec<u8>>,
//!     envelope: &Envelope<'_>,
//!     skin: &Skin<'_>,
//! ) -> Result<Bound, Error> {
//!     let batch = Batch::skinned(envelope, skin, 64);
//!     let plan = Plan::new(model, envelope, &batch, &limits(&properties.limits))?;
//!     let stages: Vec<_> = plan.stages().collect();
//!     let pipelines = unsafe { Pipelines::new(device, &stages, vk::PipelineCache::null(), None) }?;
//!
//!     let mut buffers = Buffers::default();
//!     for resource in Resource::ALL {
//!         let bytes = plan.bytes(resource);
//!         if bytes > 0 {
//!             buffers = buffers.with(resource, buffer_of(resource, bytes), 0, bytes);
//!         }
//!     }
//!
//!     let sizes = pool_sizes(&plan);
//!     let info = vk::DescriptorPoolCreateInfo::default().pool_sizes(&sizes).max_sets(set_len(&plan));
//!     let pool = unsafe { device.create_descriptor_pool(&info, None) }.map_err(vulkan("pool"))?;
//!     let layouts = pipelines.set_layouts(&plan)?;
//!     let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
//!     let sets = unsafe { device.allocate_descriptor_sets(&info) }.map_err(vulkan("sets"))?;
//!     unsafe { Bound::new(device, &pipelines, &plan, &buffers, &sets) }
//! }
//!
//! /// Records a frame of the first `instance_len` instances.
//! unsafe fn frame(
//!     device: &ash::Device,
//!     command_buffer: vk::CommandBuffer,
//!     bound: &Bound,
//!     instance_len: usize,
//! ) -> Result<(), Error> {
//!     // The host's barrier goes here: writes of poses and curves, before the compute shaders.
//!     unsafe { bound.record(device, command_buffer, instance_len) }
//!     // The host's barrier goes here: the compute shaders, before the draws.
//! }
//! ```
//!
//! [`Plan::new`]: crate::layout::Plan::new
//! [`Plan::bytes`]: crate::layout::Plan::bytes
//! [`Plan::params`]: crate::layout::Plan::params
//! [`Resource`]: crate::layout::Resource
//! [`vk::PipelineStageFlags::COMPUTE_SHADER`]: ash::vk::PipelineStageFlags::COMPUTE_SHADER
//! [`vk::AccessFlags::SHADER_READ`]: ash::vk::AccessFlags::SHADER_READ
//! [`vk::AccessFlags::SHADER_WRITE`]: ash::vk::AccessFlags::SHADER_WRITE
//! [`vk::AccessFlags::UNIFORM_READ`]: ash::vk::AccessFlags::UNIFORM_READ
#![allow(unsafe_code, reason = "every call of Vulkan is unsafe")]

mod bound;
mod error;
#[cfg(feature = "headless")]
pub mod headless;
mod pipelines;

pub use bound::{Bound, Buffers, barrier};
pub use error::Error;
pub use pipelines::{Pipelines, limits, pool_sizes, set_len, usage};
