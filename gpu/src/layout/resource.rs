//! The buffers of a batch.

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
