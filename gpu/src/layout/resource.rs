//! The buffers of a batch, and where arrays lie in them.

/// Alignment of spans in a buffer, in bytes. Every device allows this alignment.
pub const ALIGNMENT: u64 = 256;

/// A buffer of a batch, or a part of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(usize)]
pub enum Resource {
    /// Uniform: counts and offsets of all arrays. Written once, from [`super::Plan::params`].
    Params,
    /// The model's numbers, as they are in the file. Written once.
    Blob,
    /// J skinning matrices an instance, 3x4 rows, rest to posed, in model space. Written each frame.
    /// Needed only if the envelope has joints.
    Poses,
    /// The values of the C curves, instance after instance. Written each frame. Needed only if the
    /// envelope has curves.
    Curves,
    /// The numbers of a kernel's queries, instance after instance. Written each frame.
    Queries,
    /// The weights of a skin's shapes, instance after instance. Written each frame.
    Weights,
    /// Samples of signals, instance after instance. Written each frame.
    Samples,
    /// Intermediate results of the stages, and of the threads of a stage. The host never reads or
    /// writes them.
    Scratch,
    /// The palette of each instance, 3x4 rows.
    Palettes,
    /// One float an instance.
    Confidences,
    /// The host's own input to the skin: a remap, a rest mesh. Needed only if the batch has such an
    /// input.
    Host,
    /// Final outputs: shaped or skinned attributes; a kernel's outputs with their confidence; finer
    /// samples.
    Out,
}

impl Resource {
    /// Every resource.
    pub const ALL: [Self; 12] = [
        Self::Params,
        Self::Blob,
        Self::Poses,
        Self::Curves,
        Self::Queries,
        Self::Weights,
        Self::Samples,
        Self::Scratch,
        Self::Palettes,
        Self::Confidences,
        Self::Host,
        Self::Out,
    ];

    /// Returns the name of the resource, as in the shaders.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Params => "params",
            Self::Blob => "blob",
            Self::Poses => "poses",
            Self::Curves => "curves",
            Self::Queries => "queries",
            Self::Weights => "weights",
            Self::Samples => "samples",
            Self::Scratch => "scratch",
            Self::Palettes => "palettes",
            Self::Confidences => "confidences",
            Self::Host => "host",
            Self::Out => "out",
        }
    }
}

/// A range of bytes in a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// First byte, counted from the start of the host's buffer for the resource: a multiple of
    /// [`ALIGNMENT`].
    pub offset: u64,
    /// Length in bytes.
    pub bytes: u64,
}

/// Place of an array that has one run of words for each instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Array {
    /// First word of the first instance.
    pub offset: usize,
    /// Words from the start of an instance to the start of the next.
    pub stride: usize,
}

/// Place of an attribute in [`Resource::Out`]: vertex i *of the range* of instance n is at `offset
/// + n * instance_stride + i * stride`, in floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attribute {
    /// First float of the first vertex of the first instance.
    pub offset: usize,
    /// Floats from a vertex to the next; at least 3, or 4 for tangents.
    pub stride: usize,
    /// Floats from an instance to the next.
    pub instance_stride: usize,
}

impl Attribute {
    /// Returns the place as an array with one run of words for each instance.
    pub(super) fn array(&self) -> Array {
        Array { offset: self.offset, stride: self.instance_stride }
    }
}
