//! Batches of a skin's shapes, and their requirements.

use super::demand::{
    Attributes, Demand, Member, array_members, attribute_arrays, attribute_members,
    check_attributes, check_part, packed_attributes, section_member,
};
use super::error::LayoutError;
use super::resource::{Array, Attribute, Resource};
use super::stage::Stage;
use sinew_runtime::format::{PartKind, SectionKind};
use sinew_runtime::skin::BLOCK;
use sinew_runtime::{Model, Skin};
use std::ops::Range;

/// Shaped rest meshes of one skin, with an envelope or without: a [`sinew_runtime::ShapesJob`] for
/// every instance.
///
/// Offsets and strides count floats. A [`super::SkinBatch`] can use the shaped mesh as its rest
/// mesh: bind this batch's buffer of [`Resource::Out`] there as [`Resource::Host`], with attributes
/// that have no gaps between vertices.
#[derive(Clone, Debug)]
pub struct ShapesBatch {
    /// Number of instances that the buffers have room for. A frame may evaluate only the first
    /// ones; nothing is written for the others.
    pub instance_len: usize,
    /// The vertices.
    pub vertices: Range<usize>,
    /// [`Resource::Weights`]: [`Skin::shape_len`] finite weights. With a stride of 0 all instances share their weights.
    pub weights: Array,
    /// Place of the positions: 3 floats, model space.
    pub positions: Option<Attribute>,
    /// Place of the normals: 3 floats, of length 1.
    pub normals: Option<Attribute>,
    /// Place of the tangents: 3 floats of length 1, then the handedness.
    pub tangents: Option<Attribute>,
}

impl ShapesBatch {
    /// Lays out all vertices without gaps. For each instance: its V positions, its V normals and,
    /// if the skin has tangents, its V tangents.
    pub fn new(skin: &Skin<'_>, instance_len: usize) -> Self {
        let [positions, normals, tangents] = packed_attributes(skin);
        Self {
            instance_len,
            vertices: 0..skin.vertex_len(),
            weights: Array { offset: 0, stride: skin.shape_len() },
            positions,
            normals,
            tangents,
        }
    }

    fn attributes(&self) -> Attributes {
        [self.positions, self.normals, self.tangents]
    }

    /// Counts the blocks that contain vertices of the range.
    fn block_len(&self) -> u64 {
        let Range { start, end } = self.vertices;
        if start == end { 0 } else { (end.div_ceil(BLOCK) - start / BLOCK) as u64 }
    }

    /// Lists the arrays with the words of one instance.
    fn arrays(&self, shape_len: usize) -> Vec<(Resource, Array, usize)> {
        // A skin without shapes has no weights, but a binding must not be empty.
        let mut out = vec![(Resource::Weights, self.weights, shape_len.max(1))];
        out.extend(attribute_arrays(self.attributes(), self.vertices.len()));
        out
    }
}

/// Sections that shaders read; each has the name of its member.
const SECTIONS: [SectionKind; 8] = [
    SectionKind::RestPositions,
    SectionKind::RestNormals,
    SectionKind::RestTangents,
    SectionKind::Shapes,
    SectionKind::ShapeBlocks,
    SectionKind::ShapeEntries,
    SectionKind::ShapeDeltas,
    SectionKind::ShapeSlopes,
];

/// Checks a batch against a model and a skin, and returns its requirements.
pub(super) fn demand(
    model: &Model<impl AsRef<[u8]>>,
    skin: &Skin<'_>,
    batch: &ShapesBatch,
) -> Result<Demand, LayoutError> {
    check_part(model, (PartKind::Skin, skin.file()), batch.instance_len)?;
    let (vertices, vertex_len) = (batch.vertices.clone(), skin.vertex_len());
    let is_within = vertices.end <= vertex_len;
    check_attributes(batch.attributes(), vertices, vertex_len, is_within, skin.has_tangents())?;
    let counts = [
        ("vertex_first", batch.vertices.start),
        ("vertex_len", batch.vertices.len()),
        ("element", usize::from(skin.shape_element().number())),
    ];
    let counts = counts.map(|(name, number)| (name, Member::Number(number)));
    let sections = SECTIONS.map(|kind| section_member(model, Some(skin.part()), kind));
    let names = ["weights_offset", "weights_stride"];
    let weights = array_members([(names, Resource::Weights, Some(batch.weights))]);
    let attributes = attribute_members(batch.attributes());
    let members = counts.into_iter().chain(sections).chain(weights).chain(attributes);
    Ok(Demand {
        instance_len: batch.instance_len,
        stages: vec![(Stage::Shapes, batch.block_len())],
        arrays: batch.arrays(skin.shape_len()),
        members: members.collect(),
        blob_bytes: model.blob().len() as u64,
    })
}
