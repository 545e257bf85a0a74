//! A batch of instances of one model, as the host describes it.

use crate::layout::array::Array;
use crate::layout::attribute::Attribute;
use sinew_runtime::skin::SkinLayout;
use sinew_runtime::{Envelope, Skin};
use std::ops::Range;

/// Instances of one model, and where in the host's buffers their arrays lie.
///
/// Offsets and strides count words of 4 bytes: floats, and indices of a remap. Instances may lie in any
/// order that does not make two of them write to one place, which is not checked.
#[derive(Clone, Debug)]
pub struct Batch {
    /// How many instances there are room for. A frame can evaluate fewer, the first ones; nothing is
    /// written for the others.
    pub instance_len: usize,
    /// [`crate::layout::Resource::Poses`]: 12 J floats an instance. A stride of 0 gives all the same pose.
    pub poses: Array,
    /// [`crate::layout::Resource::Palettes`]: 12 floats for each transform. Where they are skinned, offset and
    /// stride are multiples of 4.
    pub palettes: Array,
    /// [`crate::layout::Resource::Confidences`]: one float; `None` leaves the stage out.
    pub confidences: Option<Array>,
    /// What to skin; `None` for the palettes only.
    pub skin: Option<SkinBatch>,
}

/// What is skinned, and where to: a [`sinew_runtime::SkinJob`] for every instance.
#[derive(Clone, Debug)]
pub struct SkinBatch {
    /// [`Skin::layout`] of a skin that follows the batch's envelope.
    pub skin: SkinLayout,
    /// The vertices: of the remap where there is one, else of the skin. An empty range is skinned by
    /// no stage, but tells a shader of the host's, in [`crate::layout::Resource::Params`], where the skin lies.
    pub vertices: Range<usize>,
    /// In [`crate::layout::Resource::Host`]: for each vertex of the engine's the skin's that it is a copy of,
    /// u32. An index beyond the mesh, which a CPU refuses, is taken for the last vertex.
    pub remap: Option<Array>,
    /// What stands for the file's rest mesh.
    pub rest: Rest,
    /// Where to put positions: 3 floats, model space.
    pub positions: Option<Attribute>,
    /// Where to put normals: 3 floats of length 1.
    pub normals: Option<Attribute>,
    /// Where to put tangents: 3 floats of length 1 and the handedness.
    pub tangents: Option<Attribute>,
}

/// A rest mesh of the host's in [`crate::layout::Resource::Host`], by the skin's own vertices. What is not given
/// is the file's. A stride of 0 gives all instances the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rest {
    /// V positions of 3 floats.
    pub positions: Option<Array>,
    /// V normals of 3 floats, of length 1.
    pub normals: Option<Array>,
    /// V tangents of 4 floats: length 1, and the handedness.
    pub tangents: Option<Array>,
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

    /// Describes palettes, confidences and the whole of a skin, as [`SkinBatch::new`] lays it out.
    pub fn skinned(envelope: &Envelope<'_>, skin: &Skin<'_>, instance_len: usize) -> Self {
        Self { skin: Some(SkinBatch::new(skin)), ..Self::palettes(envelope, instance_len) }
    }
}

impl SkinBatch {
    /// Describes the whole of a skin without gaps: instance after instance, of each its V positions,
    /// then its V normals and, where the skin has them, its V tangents.
    pub fn new(skin: &Skin<'_>) -> Self {
        let vertex_len = skin.vertex_len();
        let floats = if skin.has_tangents() { 10 } else { 6 };
        let attribute = |before: usize, stride| {
            let (offset, instance_stride) = (before * vertex_len, floats * vertex_len);
            Some(Attribute { offset, stride, instance_stride })
        };
        Self {
            skin: skin.layout(),
            vertices: 0..vertex_len,
            remap: None,
            rest: Rest::default(),
            positions: attribute(0, 3),
            normals: attribute(3, 3),
            tangents: attribute(6, 4).filter(|_| skin.has_tangents()),
        }
    }

    /// Lists the attributes with the floats of each.
    pub(super) fn attributes(&self) -> [(Option<Attribute>, usize); 3] {
        [(self.positions, 3), (self.normals, 3), (self.tangents, 4)]
    }

    /// Lists what lies in [`crate::layout::Resource::Host`], with the words of an instance: the remap up to the
    /// last vertex that is skinned, then the rest mesh of V vertices.
    pub(super) fn host(&self, vertex_len: usize) -> [(Option<Array>, usize); 4] {
        let Rest { positions, normals, tangents } = self.rest;
        let of = |floats: usize| vertex_len.saturating_mul(floats);
        [(self.remap, self.vertices.end), (positions, of(3)), (normals, of(3)), (tangents, of(4))]
    }
}
