//! The stages on the host's own Vulkan 1.0 or later, through ash.
//!
//! Nothing here owns memory of the device, submits or waits. The order of calls:
//!
//! 1. [`limits`] turns what the physical device allows into what [`Plan::new`] asks for.
//! 2. [`Pipelines::new`] makes the pipelines, once a device.
//! 3. For each batch, the host makes a buffer, or a part of one, of [`Plan::bytes`] and [`usage`] for
//!    each [`Resource`] that has any bytes; a part starts at a multiple of
//!    [`crate::layout::ALIGNMENT`]. It uploads [`Plan::params`] and [`sinew_runtime::Model::blob`].
//! 4. It makes a descriptor pool with room for [`pool_sizes`] and [`set_len`], and allocates
//!    [`Pipelines::set_layouts`] from it. [`Bound::new`] checks buffers and writes the sets.
//! 5. Each frame it writes poses, a kernel's queries, weights of shapes, or samples, and calls [`Bound::record`], which
//!    needs no memory.
//! 6. At the end it destroys pool and buffers, and calls [`Pipelines::destroy`].
//!
//! # What must be visible, and when
//! Before: blob, params, host and the frame's poses, queries, weights or samples to [`vk::PipelineStageFlags::COMPUTE_SHADER`] with
//! [`vk::AccessFlags::SHADER_READ`], params with [`vk::AccessFlags::UNIFORM_READ`]; and whatever read
//! the palettes, confidences and out of the frame before must be done. After:
//! [`vk::PipelineStageFlags::COMPUTE_SHADER`] with [`vk::AccessFlags::SHADER_WRITE`] on these three is
//! to be waited for, by vertex input, a vertex shader, or what else uses them. Those two barriers are
//! the host's; those between one stage and another, and between two records, are [`Bound::record`]'s.
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
//! /// Makes ready what each frame records.
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
//!     // The host's barrier goes here: what wrote the poses, before the compute shaders.
//!     unsafe { bound.record(device, command_buffer, instance_len) }
//!     // The host's barrier goes here: the compute shaders, before what draws.
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
#![allow(unsafe_code, reason = "every call of Vulkan is")]

mod bound;
mod error;
#[cfg(feature = "headless")]
pub mod headless;
mod pipelines;

pub use bound::{Bound, Buffers, barrier};
pub use error::Error;
pub use pipelines::{Pipelines, limits, pool_sizes, set_len, usage};
