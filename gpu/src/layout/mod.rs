//! Plans of batches, independent of any GPU API. A host on another wgpu, on Metal or on WebGPU
//! itself can drive the shaders with this module alone.
//!
//! 1. Upload [`sinew_runtime::Model::blob`] as it is: [`Resource::Blob`].
//! 2. Describe the instances and the places of their arrays: in a [`Batch`] those of an envelope,
//!    in a [`KernelBatch`] queries of a kernel, in a [`ShapesBatch`] faces of a skin, in a
//!    [`FilterBatch`] signals of a filter. [`Plan::new`], [`Plan::of_kernel`], [`Plan::of_shapes`]
//!    and [`Plan::of_filter`] check the description. They cut a batch whose bindings or dispatches
//!    would be too large. A plan has the bytes that each [`Resource`] needs and the content of
//!    [`Resource::Params`].
//! 3. Make a pipeline for each of [`Plan::stages`], entry point `main`, with the bindings of
//!    [`Stage::bindings`].
//! 4. Each frame, for each stage and each of [`Plan::chunks`]: bind [`Chunk::bound`] and dispatch
//!    [`Plan::workgroups`]. The output of a stage must be visible to the next stage that reads it.
//!
//! A dispatch's x counts the workgroups of one instance, and its y counts the instances. So every
//! instance starts with its own workgroup, and nothing is written for instances that are not
//! requested.
//!
//! A GPU computes the outputs and the confidence of a kernel. The Jacobian and the variance of a
//! kernel are computed on a CPU only.

mod demand;
mod envelope;
mod error;
mod filter;
mod kernel;
mod limits;
mod plan;
mod resource;
mod shapes;
mod stage;

pub use demand::Param;
pub use envelope::{Batch, Rest, SkinBatch};
pub use error::LayoutError;
pub use filter::FilterBatch;
pub use kernel::KernelBatch;
pub use limits::DeviceLimits;
pub use plan::{Chunk, Plan};
pub use resource::{ALIGNMENT, Array, Attribute, Resource, Span};
pub use shapes::ShapesBatch;
pub use stage::{Binding, Stage, WORKGROUP};
