//! A batch of instances of one model, as the host describes it.

use sinew_runtime::Envelope;
use sinew_runtime::envelope::Buffer;
use std::ops::Range;

/// Instances of one model, and where in the host's buffers their arrays lie.
///
/// Offsets and strides count floats. Instances may lie in any order that does not make two of them
/// write to one place, which is not checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// How many instances there are room for; a frame can evaluate fewer. What lies at instances
    /// beyond those is then of no use: as far as the last workgroup reaches, it is overwritten.
    pub instance_len: usize,
    /// [`super::Resource::Poses`]: 12 J floats an instance. A stride of 0 gives all the same pose.
    pub poses: Array,
    /// [`super::Resource::Palettes`]: 12 floats for each map of the palette. Where they are skinned,
    /// offset and stride are multiples of 4.
    pub palettes: Array,
    /// [`super::Resource::Confidences`]: one float; `None` leaves the stage out.
    pub confidences: Option<Array>,
    /// What to skin; `None` for the palettes only.
    pub skin: Option<Skin>,
}

/// Where an array with one stretch of floats an instance lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Array {
    /// The first instance's first float.
    pub offset: usize,
    /// Floats from an instance to the next.
    pub stride: usize,
}

/// What is skinned, and where to.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// The vertices, within `0..vertex_len`.
    pub vertices: Range<usize>,
    /// Where to put positions: 3 floats.
    pub positions: Option<Attribute>,
    /// Where to put normals: 3 floats of length 1.
    pub normals: Option<Attribute>,
    /// Where to put tangents: 3 floats of length 1 and the handedness.
    pub tangents: Option<Attribute>,
}

/// Where an attribute is written: vertex i *of the range* of instance n at
/// `offset + n * instance_stride + i * stride`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attribute {
    /// [`super::Resource::OutA`] or [`super::Resource::OutB`].
    pub buffer: Buffer,
    /// The first instance's first vertex.
    pub offset: usize,
    /// Floats from a vertex to the next; at least the attribute's own, 3 or 4.
    pub stride: usize,
    /// Floats from an instance to the next.
    pub instance_stride: usize,
}

impl Batch {
    /// Describes palettes and confidences one after the other, and nothing to skin.
    pub fn palettes(envelope: &Envelope<'_>, instance_len: usize) -> Self {
        Self {
            instance_len,
            poses: Array { offset: 0, stride: 12 * envelope.joint_len() },
            palettes: Array { offset: 0, stride: 12 * envelope.palette_len() },
            confidences: Some(Array { offset: 0, stride: 1 }),
            skin: None,
        }
    }

    /// Describes palettes, confidences and the whole skin: positions in buffer A, normals and, where
    /// the model has them, tangents side by side in buffer B, without gaps.
    pub fn skinned(envelope: &Envelope<'_>, instance_len: usize) -> Self {
        let vertex_len = envelope.vertex_len();
        let attribute = |buffer, offset, stride| {
            Some(Attribute { buffer, offset, stride, instance_stride: stride * vertex_len })
        };
        let stride_b = if envelope.has_tangents() { 7 } else { 3 };
        let skin = Skin {
            vertices: 0..vertex_len,
            positions: attribute(Buffer::A, 0, 3),
            normals: attribute(Buffer::B, 0, stride_b),
            tangents: attribute(Buffer::B, 3, stride_b).filter(|_| envelope.has_tangents()),
        };
        Self { skin: Some(skin), ..Self::palettes(envelope, instance_len) }
    }
}

impl Skin {
    /// Lists the attributes with the floats of each.
    pub(crate) fn attributes(&self) -> [(Option<Attribute>, usize); 3] {
        [(self.positions, 3), (self.normals, 3), (self.tangents, 4)]
    }
}
