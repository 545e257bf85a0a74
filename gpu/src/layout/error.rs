//! What a batch can have wrong, found before anything is recorded.

use super::resource::Resource;
use super::stage::Stage;
use sinew_runtime::format::PartKind;
use thiserror::Error;

/// A batch that cannot be evaluated on a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum LayoutError {
    /// There are no instances.
    #[error("no instances")]
    NoInstances,
    /// More instances are to be evaluated than the batch has room for.
    #[error("{found} instances, but room for {expected}")]
    TooManyInstances {
        /// Room of the batch.
        expected: usize,
        /// Instances asked for.
        found: usize,
    },
    /// The part is of another file than the model.
    #[error("the {} is of another file than the model", .part.name())]
    OtherFile {
        /// Which part: an envelope, a skin, a kernel or a filter.
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
    /// A skin writes no attribute.
    #[error("a skin without an attribute to write")]
    NoOutput,
    /// The vertices to skin are not inside the mesh, or the range ends before it starts, or a remap is
    /// of a mesh without vertices.
    #[error("vertices {start}..{end} of a mesh of {vertex_len}")]
    VertexRange {
        /// First vertex.
        start: usize,
        /// One past the last.
        end: usize,
        /// Vertices of the mesh.
        vertex_len: usize,
    },
    /// Tangents are asked for, and neither the skin nor the host's rest mesh has them.
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
    /// Samples have no number.
    #[error("samples of no lane")]
    NoLanes,
    /// A stride is shorter than what lies at each of its steps.
    #[error("a stride of {found} floats in {}, expected at least {least}", .resource.name())]
    Stride {
        /// Where.
        resource: Resource,
        /// Floats needed.
        least: usize,
        /// The stride.
        found: usize,
    },
    /// Palettes that are skinned are read in fours.
    #[error("palettes at float {offset} and every {stride}, expected multiples of 4")]
    Fours {
        /// The first palette's first float.
        offset: usize,
        /// Floats from a palette to the next.
        stride: usize,
    },
    /// One instance alone, or the model, needs a binding beyond what the device can bind.
    #[error("{} needs a binding of {found} bytes, more than the device's {limit}", .resource.name())]
    Binding {
        /// What is to be bound.
        resource: Resource,
        /// The device's largest binding.
        limit: u64,
        /// Bytes needed.
        found: u64,
    },
    /// A limit of the device is below what the shaders need.
    #[error("the device's {name} is {found}, expected at least {least}")]
    Device {
        /// The limit's name.
        name: &'static str,
        /// What is needed.
        least: u64,
        /// What there is.
        found: u64,
    },
    /// Bindings must start at multiples of more than [`super::ALIGNMENT`] bytes.
    #[error("the device aligns bindings to {found} bytes, expected at most {limit}")]
    OffsetAlignment {
        /// The most that is reckoned with.
        limit: u64,
        /// What the device asks for.
        found: u64,
    },
    /// One instance alone needs more workgroups than the device dispatches along an axis.
    #[error("{found} workgroups for one instance of {}, more than {limit}", .stage.name())]
    Workgroups {
        /// The stage.
        stage: Stage,
        /// The device's most.
        limit: u64,
        /// Workgroups needed.
        found: u64,
    },
    /// A buffer that the batch needs is not given.
    #[error("no buffer for {}", .resource.name())]
    Missing {
        /// What it is for.
        resource: Resource,
    },
    /// A buffer is too short.
    #[error("{} has {found} bytes, expected at least {least}", .resource.name())]
    TooShort {
        /// What it is for.
        resource: Resource,
        /// Bytes needed.
        least: u64,
        /// Bytes there.
        found: u64,
    },
    /// A buffer's offset is not a multiple of [`super::ALIGNMENT`].
    #[error("{} starts at byte {found}, not at a multiple of 256", .resource.name())]
    Misaligned {
        /// What it is for.
        resource: Resource,
        /// Where it starts.
        found: u64,
    },
    /// Two resources, of which a stage writes one, take the same bytes of a buffer.
    #[error("{} and {} overlap", .first.name(), .second.name())]
    Overlap {
        /// One.
        first: Resource,
        /// The other.
        second: Resource,
    },
}
