//! Mistakes in a batch, found before anything is recorded.

use super::resource::Resource;
use super::stage::Stage;
use sinew_runtime::format::PartKind;
use thiserror::Error;

/// Reasons why a device cannot evaluate a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum LayoutError {
    /// There are no instances.
    #[error("no instances")]
    NoInstances,
    /// More instances are requested than the batch has room for.
    #[error("{found} instances, but room for {expected}")]
    TooManyInstances {
        /// Room of the batch.
        expected: usize,
        /// Instances asked for.
        found: usize,
    },
    /// The part belongs to another file than the model.
    #[error("the {} is of another file than the model", .part.name())]
    OtherFile {
        /// The kind of part: an envelope, a skin, a kernel or a filter.
        part: PartKind,
    },
    /// The skin does not follow the envelope.
    #[error("a skin that follows {found:?}, expected part {expected}")]
    OtherEnvelope {
        /// The envelope's part.
        expected: usize,
        /// The part that the skin follows, if any.
        found: Option<usize>,
    },
    /// The skin writes no attribute.
    #[error("a skin without an attribute to write")]
    NoOutput,
    /// The range of vertices exceeds the mesh or ends before it starts, or a remap belongs to a
    /// mesh without vertices.
    #[error("vertices {start}..{end} of a mesh of {vertex_len}")]
    VertexRange {
        /// First vertex.
        start: usize,
        /// One past the last.
        end: usize,
        /// Vertices of the mesh.
        vertex_len: usize,
    },
    /// Tangents are requested, but neither the skin nor the host's rest mesh has them.
    #[error("tangents of a rest mesh that has none")]
    NoTangents,
    /// Signals are shorter than the window of their filter.
    #[error("signals of {found} samples, expected at least {least}")]
    Samples {
        /// Coarse samples of the window.
        least: usize,
        /// Samples of a signal.
        found: usize,
    },
    /// Samples have no lanes.
    #[error("samples of no lane")]
    NoLanes,
    /// A stride is shorter than the array's part for one instance or vertex.
    #[error("a stride of {found} floats in {}, expected at least {least}", .resource.name())]
    Stride {
        /// The resource.
        resource: Resource,
        /// Floats needed.
        least: usize,
        /// The stride.
        found: usize,
    },
    /// Palettes that are skinned are not aligned to 4 floats, which shaders read at a time.
    #[error("palettes at float {offset} and every {stride}, expected multiples of 4")]
    Fours {
        /// The first palette's first float.
        offset: usize,
        /// Floats from a palette to the next.
        stride: usize,
    },
    /// One instance, or the model, needs a larger binding than the device allows.
    #[error("{} needs a binding of {found} bytes, more than the device's {limit}", .resource.name())]
    Binding {
        /// The resource.
        resource: Resource,
        /// The device's largest binding.
        limit: u64,
        /// Bytes needed.
        found: u64,
    },
    /// A limit of the device is too low for the shaders.
    #[error("the device's {name} is {found}, expected at least {least}")]
    Device {
        /// The limit's name.
        name: &'static str,
        /// The least value that the shaders need.
        least: u64,
        /// The device's value.
        found: u64,
    },
    /// The device requires a coarser alignment of bindings than [`super::ALIGNMENT`] bytes.
    #[error("the device aligns bindings to {found} bytes, expected at most {limit}")]
    OffsetAlignment {
        /// The coarsest alignment that is supported.
        limit: u64,
        /// The device's alignment.
        found: u64,
    },
    /// One instance needs more workgroups than the device dispatches along an axis.
    #[error("{found} workgroups for one instance of {}, more than {limit}", .stage.name())]
    Workgroups {
        /// The stage.
        stage: Stage,
        /// The device's limit.
        limit: u64,
        /// Workgroups needed.
        found: u64,
    },
    /// A buffer that the batch needs is missing.
    #[error("no buffer for {}", .resource.name())]
    Missing {
        /// The resource that needs the buffer.
        resource: Resource,
    },
    /// A buffer is too short.
    #[error("{} has {found} bytes, expected at least {least}", .resource.name())]
    TooShort {
        /// The resource that needs the buffer.
        resource: Resource,
        /// Bytes needed.
        least: u64,
        /// Bytes of the buffer.
        found: u64,
    },
    /// A buffer's offset is not a multiple of [`super::ALIGNMENT`].
    #[error("{} starts at byte {found}, not at a multiple of 256", .resource.name())]
    Misaligned {
        /// The resource that needs the buffer.
        resource: Resource,
        /// The buffer's offset, in bytes.
        found: u64,
    },
    /// Two resources overlap in a buffer, and a stage writes to one of them.
    #[error("{} and {} overlap", .first.name(), .second.name())]
    Overlap {
        /// One resource.
        first: Resource,
        /// The other resource.
        second: Resource,
    },
}
