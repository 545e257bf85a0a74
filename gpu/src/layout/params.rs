//! The uniform block: counts, and where each array lies in its binding, in words of 4 bytes.

use super::batch::{Array, Attribute, Batch};
use super::chunk::{Param, Spans};
use super::resource::Resource;
use sinew_runtime::envelope::ScratchLayout;
use sinew_runtime::format::SectionKind;
use sinew_runtime::{Envelope, Model, Skin};

/// Bytes of the block: 56 members.
pub(super) const PARAM_BYTES: u64 = 224;

/// Stands for the offset of an array, or of a section, that is not there.
const NONE: usize = u32::MAX as usize;

/// The sections that shaders read, by the name of their member: the skin's, or the envelope's.
const SECTIONS: [(bool, SectionKind); 14] = [
    (false, SectionKind::Hierarchy),
    (true, SectionKind::RestPositions),
    (true, SectionKind::RestNormals),
    (true, SectionKind::RestTangents),
    (true, SectionKind::InfluenceIndices),
    (true, SectionKind::InfluenceWeights),
    (true, SectionKind::TangentCoefficients),
    (false, SectionKind::Keys),
    (false, SectionKind::C1),
    (false, SectionKind::C2),
    (false, SectionKind::PoseRanges),
    (false, SectionKind::Origins),
    (false, SectionKind::Groups),
    (false, SectionKind::Corrections),
];

/// What of a model is evaluated.
pub(super) struct Parts<'a, B> {
    pub(super) model: &'a Model<B>,
    pub(super) envelope: &'a Envelope<'a>,
    pub(super) skin: Option<Skin<'a>>,
    pub(super) scratch: ScratchLayout,
}

impl<B: AsRef<[u8]>> Parts<'_, B> {
    /// Lists the members of a chunk's block, in the order in which they lie in it.
    ///
    /// - `first`: the chunk's first instance.
    pub(super) fn params(&self, batch: &Batch, first: usize, spans: &Spans) -> Vec<Param> {
        let Self { envelope, skin, scratch, .. } = self;
        let vertices = batch.skin.as_ref().map_or(0..0, |skin| skin.vertices.clone());
        let counts = [
            ("vertex_first", vertices.start),
            ("vertex_len", vertices.len()),
            ("mesh_len", skin.map_or(0, |skin| skin.vertex_len())),
            ("influence_len", skin.map_or(0, |skin| skin.influence_len())),
            ("joint_len", envelope.joint_len()),
            ("proxy_len", envelope.proxy_len()),
            ("palette_len", envelope.palette_len()),
            ("group_len", envelope.group_len()),
            ("root", envelope.root()),
            ("predictor", usize::from(envelope.predictor().number())),
        ];
        let sections = SECTIONS.map(|(of_skin, kind)| (kind.name(), self.section(of_skin, kind)));
        let inner = [
            ("relative", scratch.relative),
            ("rotations", scratch.rotations),
            ("gradients", scratch.gradients),
            ("features", scratch.features),
            ("group_confidences", scratch.confidences),
            ("group_scratch", scratch.groups),
            ("group_stride", scratch.group_stride),
        ];
        // Where in its binding an array of the batch has the chunk's first instance.
        let place = |resource: Resource, array: Option<Array>| {
            let (Some(Array { offset, stride }), Some(span)) = (array, spans[resource as usize])
            else {
                return [NONE, 0];
            };
            let at = (first as u64).saturating_mul(stride as u64).saturating_add(offset as u64);
            [at.saturating_sub(span.offset / 4) as usize, stride]
        };
        let own = batch.skin.as_ref();
        let mesh = own.map(|own| own.rest).unwrap_or_default();
        let arrays = [
            (
                ["scratch_offset", "scratch_stride"],
                Resource::Scratch,
                Some(Array { offset: 0, stride: scratch.len }),
            ),
            (["poses_offset", "poses_stride"], Resource::Poses, Some(batch.poses)),
            (["palettes_offset", "palettes_stride"], Resource::Palettes, Some(batch.palettes)),
            (
                ["confidences_offset", "confidences_stride"],
                Resource::Confidences,
                batch.confidences,
            ),
            (
                ["host_remap_offset", "host_remap_stride"],
                Resource::Host,
                own.and_then(|own| own.remap),
            ),
            (["host_positions_offset", "host_positions_stride"], Resource::Host, mesh.positions),
            (["host_normals_offset", "host_normals_stride"], Resource::Host, mesh.normals),
            (["host_tangents_offset", "host_tangents_stride"], Resource::Host, mesh.tangents),
        ];
        let arrays = arrays.into_iter().flat_map(|([offset, stride], resource, array)| {
            let place = place(resource, array);
            [(offset, place[0]), (stride, place[1])]
        });
        let attribute = |names: [&'static str; 3], attribute: Option<Attribute>| {
            let array =
                attribute.map(|own| Array { offset: own.offset, stride: own.instance_stride });
            let [offset, instance_stride] = place(Resource::Out, array);
            let stride = attribute.map_or(0, |own| own.stride);
            [(names[0], offset), (names[1], stride), (names[2], instance_stride)]
        };
        let attributes = [
            attribute(
                ["positions_offset", "positions_stride", "positions_instance_stride"],
                own.and_then(|own| own.positions),
            ),
            attribute(
                ["normals_offset", "normals_stride", "normals_instance_stride"],
                own.and_then(|own| own.normals),
            ),
            attribute(
                ["tangents_offset", "tangents_stride", "tangents_instance_stride"],
                own.and_then(|own| own.tangents),
            ),
        ];
        let all = counts.into_iter().chain(sections).chain(inner).chain(arrays);
        // What lies within a binding has 30 bits; a longer stride is never taken.
        all.chain(attributes.into_iter().flatten())
            .map(|(name, value)| (name, u32::try_from(value).unwrap_or(u32::MAX)))
            .collect()
    }

    /// Returns the first word of a section in the blob.
    fn section(&self, of_skin: bool, kind: SectionKind) -> usize {
        let part =
            if of_skin { self.skin.map(|skin| skin.part()) } else { Some(self.envelope.part()) };
        let mut rows = self.model.sections().map(|section| section.row);
        let found =
            rows.find(|row| Some(usize::from(row.part)) == part && row.kind == kind.number());
        found.map_or(NONE, |row| row.offset as usize / 4)
    }
}
