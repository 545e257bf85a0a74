//! The stages on wgpu: dispatches recorded into the host's command encoder, over the host's
//! buffers.
//!
//! Once for each device: [`Pipelines::new`]. Once for each batch:
//! [`Plan::new`](crate::layout::Plan::new) with the device's [`limits`], buffers of
//! [`Plan::bytes`](crate::layout::Plan::bytes), and [`Bound::new`]. Each frame: the host writes
//! poses, [`Bound::encode`] records, and the host submits. This module never submits or waits, and
//! allocates nothing after [`Bound::new`].
//!
//! | resource | required usage | task of the host |
//! |---|---|---|
//! | [`Params`](crate::layout::Resource::Params) | `UNIFORM` | writes [`Plan::params`](crate::layout::Plan::params) once |
//! | [`Blob`](crate::layout::Resource::Blob) | `STORAGE` | writes [`Model::blob`](sinew_runtime::Model::blob) once, zeros up to a whole word |
//! | [`Poses`](crate::layout::Resource::Poses) | `STORAGE` | writes J skinning matrices an instance each frame |
//! | [`Curves`](crate::layout::Resource::Curves) | `STORAGE` | writes the values of the C curves an instance each frame, if the model has any |
//! | [`Queries`](crate::layout::Resource::Queries) | `STORAGE` | writes the numbers of a kernel's query an instance each frame |
//! | [`Weights`](crate::layout::Resource::Weights) | `STORAGE` | writes the weights of a skin's shapes an instance each frame |
//! | [`Samples`](crate::layout::Resource::Samples) | `STORAGE` | writes the samples of a signal an instance each frame |
//! | [`Scratch`](crate::layout::Resource::Scratch) | `STORAGE` | never reads or writes it; batches encoded one after another may share it |
//! | [`Palettes`](crate::layout::Resource::Palettes), [`Confidences`](crate::layout::Resource::Confidences), [`Out`](crate::layout::Resource::Out) | `STORAGE` | reads them |
//! | [`Host`](crate::layout::Resource::Host) | `STORAGE` | writes a remap or a rest mesh, if it has one |
//!
//! The host adds usages for its own purposes: `COPY_DST` to write, `VERTEX` to draw. Commands that
//! are recorded or submitted later can read the outputs, because wgpu orders and synchronises them.
//! The CPU sees the outputs after a copy to a buffer that is mapped.
//!
//! Poses and curves must be finite, and a joint that never stretched in training must be rigid to
//! 1e-4; `sinew_runtime`'s `Envelope::check_pose` checks that in a debug build. The CPU refuses
//! poses and curves that are not finite. A GPU cannot refuse, and its output for such an instance is
//! meaningless; other instances are not affected. If the CPU would refuse a kernel's query, the GPU
//! writes NaN as its confidence.
//!
//! Kernels, shapes and filters are bound and encoded in the same way. For a kernel, call
//! [`Plan::of_kernel`](crate::layout::Plan::of_kernel) with a
//! [`KernelBatch`](crate::layout::KernelBatch). For shapes, call
//! [`Plan::of_shapes`](crate::layout::Plan::of_shapes) with a
//! [`ShapesBatch`](crate::layout::ShapesBatch), and encode them before the skin that uses the
//! shaped rest mesh. For signals, call [`Plan::of_filter`](crate::layout::Plan::of_filter) with a
//! [`FilterBatch`](crate::layout::FilterBatch).
//!
//! ```no_run
//! use sinew_gpu::layout::{Batch, Plan, Resource};
//! use sinew_gpu::wgpu::{Bound, Buffers, Pipelines, limits};
//! use sinew_runtime::{Envelope, Model, Skin};
//! use wgpu::{BufferDescriptor, BufferUsages};
//!
//! # fn frame(device: wgpu::Device, queue: wgpu::Queue, file: &[u8], poses: &[u8])
//! # -> Result<(), Box<dyn std::error::Error>> {
//! let model = Model::from_bytes(file)?;
//! let envelope = model.first::<Envelope>().ok_or("no envelope")?;
//! let skin = model.first::<Skin>().ok_or("no skin")?;
//!
//! // Once.
//! let batch = Batch::skinned(&envelope, &skin, 64);
//! let plan = Plan::new(&model, &envelope, &batch, &limits(&device.limits()))?;
//! let pipelines = Pipelines::new(&device, plan.stages())?;
//! let buffer = |resource, usage| {
//!     device.create_buffer(&BufferDescriptor {
//!         label: None,
//!         size: plan.bytes(resource),
//!         usage,
//!         mapped_at_creation: false,
//!     })
//! };
//! let written = BufferUsages::STORAGE | BufferUsages::COPY_DST;
//! let drawn = BufferUsages::STORAGE | BufferUsages::VERTEX;
//! let params = buffer(Resource::Params, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
//! let blob = buffer(Resource::Blob, written);
//! let posed = buffer(Resource::Poses, written);
//! let scratch = buffer(Resource::Scratch, BufferUsages::STORAGE);
//! let palettes = buffer(Resource::Palettes, BufferUsages::STORAGE);
//! let confidences = buffer(Resource::Confidences, BufferUsages::STORAGE);
//! let skinned = buffer(Resource::Out, drawn);
//! queue.write_buffer(&params, 0, &plan.params());
//! let mut content = model.blob().to_vec();
//! content.resize(plan.bytes(Resource::Blob) as usize, 0);
//! queue.write_buffer(&blob, 0, &content);
//! let buffers = Buffers::new()
//!     .with(Resource::Params, &params, 0)
//!     .with(Resource::Blob, &blob, 0)
//!     .with(Resource::Poses, &posed, 0)
//!     .with(Resource::Scratch, &scratch, 0)
//!     .with(Resource::Palettes, &palettes, 0)
//!     .with(Resource::Confidences, &confidences, 0)
//!     .with(Resource::Out, &skinned, 0);
//! let bound = Bound::new(&pipelines, &plan, &buffers)?;
//!
//! // Each frame.
//! queue.write_buffer(&posed, 0, poses);
//! let mut encoder = device.create_command_encoder(&Default::default());
//! bound.encode(&mut encoder, 64)?;
//! queue.submit([encoder.finish()]);
//! # Ok(())
//! # }
//! ```

mod bound;
mod error;
#[cfg(feature = "headless")]
pub mod headless;
mod pipelines;

pub use bound::{Bound, Buffers};
pub use error::Error;
pub use pipelines::{Pipelines, limits};
