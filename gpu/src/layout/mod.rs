//! What a GPU needs to know of a model and of a batch of instances, in terms of no API: a host on
//! another wgpu, on Metal or on WebGPU proper can drive the shaders with this module alone.
//!
//! 1. Upload [`sinew_runtime::Model::blob`] as it is: [`Resource::Blob`].
//! 2. Say in a [`Batch`] how many instances there are and where their arrays lie; [`Plan::new`]
//!    checks that, cuts it where a binding would be too large, and gives the bytes that each
//!    [`Resource`] needs and the content of [`Resource::Params`].
//! 3. Make a pipeline of each of [`Plan::stages`], entry point `main`, bound as [`Stage::bindings`]
//!    lists.
//! 4. Each frame, for each stage and each of [`Plan::chunks`]: bind the chunk's [`Span`]s and
//!    dispatch [`Plan::groups`]. What a stage writes must be visible to the next.

mod batch;
mod error;
mod params;
mod plan;
mod stage;

pub use batch::{Array, Attribute, Batch, Skin};
pub use error::LayoutError;
pub use params::{Param, WorkLayout};
pub use plan::{Chunk, DeviceLimits, Plan, Span};
pub use sinew_runtime::envelope::Buffer;
pub use stage::{Binding, Stage, WORKGROUP};

/// Where a span of a buffer may start, in bytes: what every device allows.
pub const ALIGNMENT: u64 = 256;

/// The buffers of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(usize)]
pub enum Resource {
    /// Uniform: where everything lies. Written once, from [`Plan::params`].
    Params,
    /// The model's numbers, as they lie in the file. Written once.
    Blob,
    /// J skinning matrices an instance, 3x4 rows, rest to posed, in model space. Written each frame.
    Poses,
    /// What stages hand to each other. Never read or written by the host.
    Work,
    /// The palette of each instance, 3x4 rows.
    Palettes,
    /// One float an instance.
    Confidences,
    /// Skinned attributes.
    OutA,
    /// Skinned attributes.
    OutB,
}

impl Resource {
    /// Every resource.
    pub const ALL: [Self; 8] = [
        Self::Params,
        Self::Blob,
        Self::Poses,
        Self::Work,
        Self::Palettes,
        Self::Confidences,
        Self::OutA,
        Self::OutB,
    ];

    /// Returns its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Params => "params",
            Self::Blob => "blob",
            Self::Poses => "poses",
            Self::Work => "work",
            Self::Palettes => "palettes",
            Self::Confidences => "confidences",
            Self::OutA => "out_a",
            Self::OutB => "out_b",
        }
    }
}
