//! What a GPU needs to know of a model and of a batch of instances, in terms of no API: a host on
//! another wgpu, on Metal or on WebGPU proper can drive the shaders with this module alone.
//!
//! 1. Upload [`sinew_runtime::Model::blob`] as it is: [`Resource::Blob`].
//! 2. Say in a [`Batch`] how many instances of an envelope there are, in a [`KernelBatch`] how many
//!    queries of a kernel, in a [`ShapesBatch`] how many faces of a skin, or in a [`FilterBatch`] how many signals of a
//!    filter, and where their arrays lie; [`Plan::new`], [`Plan::of_kernel`], [`Plan::of_shapes`] or
//!    [`Plan::of_filter`] checks that, cuts it where a binding or a dispatch would be too large, and gives the bytes that each
//!    [`Resource`] needs and the content of [`Resource::Params`].
//! 3. Make a pipeline of each of [`Plan::stages`], entry point `main`, bound as [`Stage::bindings`]
//!    lists.
//! 4. Each frame, for each stage and each of [`Plan::chunks`]: bind [`Chunk::bound`] and dispatch
//!    [`Plan::workgroups`]. What a stage writes must be visible to the next that reads it.
//!
//! A dispatch's x counts the workgroups of one instance and its y the instances, so that every instance
//! starts at a workgroup, and nothing is ever written for one that is not asked for.
//!
//! Of a kernel, outputs and the confidence are computed here; its Jacobian and its variance on a CPU alone.

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
