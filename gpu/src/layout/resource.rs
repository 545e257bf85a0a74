//! The buffers of a batch, and where arrays lie in them.

/// Where a span of a buffer may start, in bytes: what every device allows.
pub const ALIGNMENT: u64 = 256;

/// A buffer of a batch, or a part of one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(usize)]
pub enum Resource {
    /// Uniform: where everything lies. Written once, from [`super::Plan::params`].
    Params,
    /// The model's numbers, as they lie in the file. Written once.
    Blob,
    /// J skinning matrices an instance, 3x4 rows, rest to posed, in model space. Written each frame.
    Poses,
    /// The numbers of a kernel's query, an instance after the other. Written each frame.
    Queries,
    /// The weights of a skin's shapes, an instance after the other. Written each frame.
    Weights,
    /// Samples of signals, an instance after the other. Written each frame.
    Samples,
    /// What stages hand to each other, and threads of a stage. Never read or written by the host.
    Scratch,
    /// The palette of each instance, 3x4 rows.
    Palettes,
    /// One float an instance.
    Confidences,
    /// What the host brings to the skin: a remap, a rest mesh. Only a batch that names one needs it.
    Host,
    /// What comes out at the far end: shaped or skinned attributes; a kernel's outputs and the confidence in them; finer
    /// samples.
    Out,
}

impl Resource {
    /// Every resource.
    pub const ALL: [Self; 11] = [
        Self::Params,
        Self::Blob,
        Self::Poses,
        Self::Queries,
        Self::Weights,
        Self::Samples,
        Self::Scratch,
        Self::Palettes,
        Self::Confidences,
        Self::Host,
        Self::Out,
    ];

    /// Returns its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Params => "params",
            Self::Blob => "blob",
            Self::Poses => "poses",
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

/// Bytes of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The first, from where the host's buffer for the resource starts: a multiple of
    /// [`super::ALIGNMENT`].
    pub offset: u64,
    /// How many.
    pub bytes: u64,
}

/// Where an array with one stretch of words an instance lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Array {
    /// The first instance's first word.
    pub offset: usize,
    /// Words from an instance to the next.
    pub stride: usize,
}

/// Where an attribute is written in [`super::Resource::Out`]: vertex i *of the range* of instance n at
/// `offset + n * instance_stride + i * stride`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attribute {
    /// The first instance's first vertex.
    pub offset: usize,
    /// Floats from a vertex to the next; at least the attribute's own, 3 or 4.
    pub stride: usize,
    /// Floats from an instance to the next.
    pub instance_stride: usize,
}

impl Attribute {
    /// Returns where it lies, as an array with a stretch of words an instance.
    pub(super) fn array(&self) -> Array {
        Array { offset: self.offset, stride: self.instance_stride }
    }
}
