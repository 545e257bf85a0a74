//! The uniform block: counts, and where each array lies in its binding, in words of 4 bytes.

use super::plan::Chunk;
use super::{Array, Attribute, Batch, Resource};
use sinew_runtime::envelope::Buffer;
use sinew_runtime::format::SectionKind;
use sinew_runtime::{Envelope, Model};

/// A member of the block, u32, and its value.
pub type Param = (&'static str, u32);

/// Bytes of the block: 50 members, up to a whole number of vectors of four.
pub(super) const PARAM_BYTES: u64 = 208;

/// The sections that shaders read, by the name of their member.
const SECTIONS: [SectionKind; 13] = [
    SectionKind::Hierarchy,
    SectionKind::RestPositions,
    SectionKind::RestNormals,
    SectionKind::RestTangents,
    SectionKind::InfluenceIndices,
    SectionKind::InfluenceWeights,
    SectionKind::Keys,
    SectionKind::C1,
    SectionKind::C2,
    SectionKind::PoseRanges,
    SectionKind::Origins,
    SectionKind::Groups,
    SectionKind::Corrections,
];

/// Where things lie in the work of one instance, in floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorkLayout {
    /// The stack q: 4 J columns of 3.
    pub relative: usize,
    /// J rotation vectors of 3.
    pub rotations: usize,
    /// The stack d: 3 P columns of 3.
    pub gradients: usize,
    /// The features: J matrices of 12.
    pub features: usize,
    /// w of each of the G groups.
    pub certainties: usize,
    /// The scratch of each of the G groups: x (d), g (n), 1 - b (n), z (r), each in whole blocks of 8.
    pub scratch: usize,
    /// Floats from a group's scratch to the next group's.
    pub scratch_stride: usize,
    /// Floats of all of it, and from an instance to the next.
    pub len: usize,
}

impl WorkLayout {
    /// Lays out what an envelope's stages need.
    pub fn new(envelope: &Envelope<'_>) -> Self {
        let (joint_len, group_len) = (envelope.joint_len(), envelope.group_len());
        let (base, correction) = match envelope.predictor() {
            predictor if !predictor.reconstructs() => (0, usize::from(group_len > 0)),
            predictor => (1, usize::from(predictor.corrects() && group_len > 0)),
        };
        let padded = |len: usize| len.next_multiple_of(8);
        let scratch_of = |[d, n, r]: [usize; 3]| padded(d) + 2 * padded(n) + padded(r);
        let sizes = envelope.groups().map(|g| [g.input_len(), g.centre_len(), g.rank()]);
        let scratch_stride = sizes.map(scratch_of).max().unwrap_or(0);
        let relative = 0;
        let rotations = relative + base * 12 * joint_len;
        let gradients = rotations + base * 3 * joint_len;
        let features = gradients + base * 9 * envelope.proxy_len();
        let certainties = features + correction * 12 * joint_len;
        let scratch = certainties + correction * group_len;
        // Never nothing: it is bound in any case.
        let len = (scratch + group_len * scratch_stride).max(1);
        Self { relative, rotations, gradients, features, certainties, scratch, scratch_stride, len }
    }
}

/// Lists the members of a chunk's block, in the order in which they lie in it.
pub(super) fn params(
    model: &Model<'_>,
    envelope: &Envelope<'_>,
    batch: &Batch,
    chunk: &Chunk,
) -> Vec<Param> {
    let vertices = batch.skin.as_ref().map_or(0..0, |skin| skin.vertices.clone());
    let counts = [
        ("instance_len", chunk.instances.len()),
        ("vertex_first", vertices.start),
        ("vertex_len", vertices.len()),
        ("joint_len", envelope.joint_len()),
        ("proxy_len", envelope.proxy_len()),
        ("palette_len", envelope.palette_len()),
        ("influence_len", envelope.influence_len()),
        ("group_len", envelope.group_len()),
        ("root", envelope.root()),
        ("predictor", usize::from(envelope.predictor().number())),
    ];
    let sections = SECTIONS.map(|kind| {
        let mut rows = model.sections().map(|section| section.row);
        let found =
            rows.find(|row| usize::from(row.part) == envelope.part() && row.kind == kind.number());
        (kind.name(), found.map_or(0, |row| row.offset as usize / 4))
    });
    let work = WorkLayout::new(envelope);
    let inner = [
        ("relative", work.relative),
        ("rotations", work.rotations),
        ("gradients", work.gradients),
        ("features", work.features),
        ("certainties", work.certainties),
        ("scratch", work.scratch),
        ("scratch_stride", work.scratch_stride),
    ];
    let place = |resource, array: Array| {
        [chunk.offset_of(resource, array.offset, array.stride), array.stride]
    };
    let [work_offset, work_stride] = place(Resource::Work, Array { offset: 0, stride: work.len });
    let [poses_offset, poses_stride] = place(Resource::Poses, batch.poses);
    let [palettes_offset, palettes_stride] = place(Resource::Palettes, batch.palettes);
    let [confidences_offset, confidences_stride] =
        batch.confidences.map_or([0; 2], |array| place(Resource::Confidences, array));
    let arrays = [
        ("work_offset", work_offset),
        ("work_stride", work_stride),
        ("poses_offset", poses_offset),
        ("poses_stride", poses_stride),
        ("palettes_offset", palettes_offset),
        ("palettes_stride", palettes_stride),
        ("confidences_offset", confidences_offset),
        ("confidences_stride", confidences_stride),
    ];
    let attribute = |attribute: Option<Attribute>| {
        attribute.map_or([0; 4], |Attribute { buffer, offset, stride, instance_stride }| {
            let (number, resource) = out(buffer);
            [number, chunk.offset_of(resource, offset, instance_stride), stride, instance_stride]
        })
    };
    let skin = batch.skin.as_ref();
    let [p0, p1, p2, p3] = attribute(skin.and_then(|skin| skin.positions));
    let [n0, n1, n2, n3] = attribute(skin.and_then(|skin| skin.normals));
    let [t0, t1, t2, t3] = attribute(skin.and_then(|skin| skin.tangents));
    // Buffers: 0 for none, 1 for A, 2 for B.
    let attributes = [
        ("positions_buffer", p0),
        ("positions_offset", p1),
        ("positions_stride", p2),
        ("positions_instance_stride", p3),
        ("normals_buffer", n0),
        ("normals_offset", n1),
        ("normals_stride", n2),
        ("normals_instance_stride", n3),
        ("tangents_buffer", t0),
        ("tangents_offset", t1),
        ("tangents_stride", t2),
        ("tangents_instance_stride", t3),
    ];
    let all = counts.iter().chain(&sections).chain(&inner).chain(&arrays).chain(&attributes);
    // What lies within a binding has 30 bits; a longer stride is never taken.
    all.map(|&(name, value)| (name, u32::try_from(value).unwrap_or(u32::MAX))).collect()
}

/// Returns an output buffer's number in the block, and what is bound for it.
pub(super) fn out(buffer: Buffer) -> (usize, Resource) {
    match buffer {
        Buffer::A => (1, Resource::OutA),
        Buffer::B => (2, Resource::OutB),
    }
}
