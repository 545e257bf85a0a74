//! Batches of an envelope, and of a skin that follows it.

use super::demand::{
    Attributes, Demand, Member, array_members, attribute_arrays, attribute_members,
    check_attribute_strides, check_stride, packed_attributes, section_member, threads,
};
use super::error::LayoutError;
use super::resource::{Array, Attribute, Resource};
use super::stage::Stage;
use sinew_runtime::envelope::ScratchLayout;
use sinew_runtime::format::{PartKind, SectionKind};
use sinew_runtime::skin::SkinLayout;
use sinew_runtime::{Envelope, Model, Skin};
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
    /// [`Resource::Poses`]: 12 J floats an instance. A stride of 0 gives all the same pose.
    pub poses: Array,
    /// [`Resource::Palettes`]: 12 floats for each transform. Where they are skinned, offset and
    /// stride are multiples of 4.
    pub palettes: Array,
    /// [`Resource::Confidences`]: one float; `None` leaves the stage out.
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
    /// no stage, but tells a shader of the host's, in [`Resource::Params`], where the skin lies.
    pub vertices: Range<usize>,
    /// In [`Resource::Host`]: for each vertex of the engine's the skin's that it is a copy of,
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

/// A rest mesh of the host's in [`Resource::Host`], by the skin's own vertices. What is not given
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
        let [positions, normals, tangents] = packed_attributes(skin);
        Self {
            skin: skin.layout(),
            vertices: 0..skin.vertex_len(),
            remap: None,
            rest: Rest::default(),
            positions,
            normals,
            tangents,
        }
    }

    fn attributes(&self) -> Attributes {
        [self.positions, self.normals, self.tangents]
    }

    /// Lists what lies in [`Resource::Host`], with the words of an instance: the remap up to the
    /// last vertex that is skinned, then the rest mesh of V vertices.
    fn host(&self, vertex_len: usize) -> [(Option<Array>, usize); 4] {
        let Rest { positions, normals, tangents } = self.rest;
        let of = |floats: usize| vertex_len.saturating_mul(floats);
        [(self.remap, self.vertices.end), (positions, of(3)), (normals, of(3)), (tangents, of(4))]
    }
}

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

/// Checks a batch against a model and an envelope, and says what it asks for.
pub(super) fn demand(
    model: &Model<impl AsRef<[u8]>>,
    envelope: &Envelope<'_>,
    batch: &Batch,
) -> Result<Demand, LayoutError> {
    let skin = check(model, envelope, batch)?;
    let scratch = ScratchLayout::at_once(envelope);
    let section = |&(of_skin, kind): &(bool, SectionKind)| {
        let part = if of_skin { skin.map(|skin| skin.part()) } else { Some(envelope.part()) };
        section_member(model, part, kind)
    };
    let members = counts(envelope, skin.as_ref(), batch)
        .into_iter()
        .chain(SECTIONS.iter().map(section))
        .chain(inner(&scratch))
        .chain(outer(batch, &scratch));
    Ok(Demand {
        instance_len: batch.instance_len,
        stages: stages(envelope, batch),
        arrays: arrays(envelope, skin.as_ref(), batch, &scratch),
        members: members.collect(),
        blob_bytes: model.blob().len() as u64,
    })
}

/// Lists the stages of a batch, in the order of [`Stage::ALL`], with the workgroups of one instance: none
/// of those that the predictor has no use for.
fn stages(envelope: &Envelope<'_>, batch: &Batch) -> Vec<(Stage, u64)> {
    let predictor = envelope.predictor();
    let vertex_len = batch.skin.as_ref().map_or(0, |skin| skin.vertices.len());
    let reconstructs = u64::from(predictor.reconstructs());
    let corrects = u64::from(predictor.corrects());
    let features = if envelope.group_len() > 0 { threads(envelope.joint_len()) } else { 0 };
    vec![
        (Stage::Gradients, reconstructs),
        (Stage::Palette, reconstructs * threads(envelope.proxy_len())),
        (Stage::Joints, (1 - reconstructs) * threads(envelope.palette_len())),
        (Stage::Features, corrects * features),
        (Stage::Correction, corrects * envelope.group_len() as u64),
        (Stage::Skin, threads(vertex_len)),
        (Stage::Confidence, u64::from(batch.confidences.is_some())),
    ]
}

/// Lists the arrays with the words of one instance.
fn arrays(
    envelope: &Envelope<'_>,
    skin: Option<&Skin<'_>>,
    batch: &Batch,
    scratch: &ScratchLayout,
) -> Vec<(Resource, Array, usize)> {
    let own = Array { offset: 0, stride: scratch.len };
    let mut out = vec![
        (Resource::Poses, batch.poses, 12 * envelope.joint_len()),
        (Resource::Scratch, own, scratch.len),
        (Resource::Palettes, batch.palettes, 12 * envelope.palette_len()),
    ];
    out.extend(batch.confidences.map(|array| (Resource::Confidences, array, 1)));
    let Some(own) = &batch.skin else { return out };
    if own.vertices.is_empty() {
        return out;
    }
    let host = own.host(skin.map_or(0, |skin| skin.vertex_len())).into_iter();
    out.extend(host.filter_map(|(array, len)| Some((Resource::Host, array?, len))));
    out.extend(attribute_arrays(own.attributes(), own.vertices.len()));
    out
}

/// Lists the members that count.
fn counts(
    envelope: &Envelope<'_>,
    skin: Option<&Skin<'_>>,
    batch: &Batch,
) -> [(&'static str, Member); 10] {
    let vertices = batch.skin.as_ref().map_or(0..0, |skin| skin.vertices.clone());
    [
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
    ]
    .map(number)
}

/// Lists where arrays lie in the scratch of an instance.
fn inner(scratch: &ScratchLayout) -> [(&'static str, Member); 7] {
    [
        ("relative", scratch.relative),
        ("rotations", scratch.rotations),
        ("gradients", scratch.gradients),
        ("features", scratch.features),
        ("group_confidences", scratch.confidences),
        ("group_scratch", scratch.groups),
        ("group_stride", scratch.group_stride),
    ]
    .map(number)
}

/// Lists where arrays lie in their bindings.
fn outer(batch: &Batch, scratch: &ScratchLayout) -> Vec<(&'static str, Member)> {
    let own = batch.skin.as_ref();
    let rest = own.map(|own| own.rest).unwrap_or_default();
    let scratch = Some(Array { offset: 0, stride: scratch.len });
    let remap = own.and_then(|own| own.remap);
    let arrays = [
        (["scratch_offset", "scratch_stride"], Resource::Scratch, scratch),
        (["poses_offset", "poses_stride"], Resource::Poses, Some(batch.poses)),
        (["palettes_offset", "palettes_stride"], Resource::Palettes, Some(batch.palettes)),
        (["confidences_offset", "confidences_stride"], Resource::Confidences, batch.confidences),
        (["host_remap_offset", "host_remap_stride"], Resource::Host, remap),
        (["host_positions_offset", "host_positions_stride"], Resource::Host, rest.positions),
        (["host_normals_offset", "host_normals_stride"], Resource::Host, rest.normals),
        (["host_tangents_offset", "host_tangents_stride"], Resource::Host, rest.tangents),
    ];
    let arrays = arrays
        .into_iter()
        .flat_map(|(names, resource, array)| array_members(names, resource, array));
    let attributes = own.map(SkinBatch::attributes).unwrap_or_default();
    arrays.chain(attribute_members(attributes)).collect()
}

fn number((name, number): (&'static str, usize)) -> (&'static str, Member) {
    (name, Member::Number(number))
}

/// Checks a batch against a model and an envelope, and opens its skin.
fn check<'a>(
    model: &'a Model<impl AsRef<[u8]>>,
    envelope: &Envelope<'_>,
    batch: &Batch,
) -> Result<Option<Skin<'a>>, LayoutError> {
    if envelope.file() != model.id() {
        return Err(LayoutError::OtherFile { part: PartKind::Envelope });
    }
    if batch.instance_len == 0 {
        return Err(LayoutError::NoInstances);
    }
    check_stride(Resource::Palettes, 12 * envelope.palette_len(), batch.palettes.stride)?;
    if let Some(array) = batch.confidences {
        check_stride(Resource::Confidences, 1, array.stride)?;
    }
    let Some(own) = &batch.skin else { return Ok(None) };
    let skin = own.skin.open(model.as_bytes());
    let skin = skin.ok_or(LayoutError::OtherFile { part: PartKind::Skin })?;
    let (expected, found) = (envelope.part(), skin.envelope_part());
    if found != Some(expected) {
        return Err(LayoutError::OtherEnvelope { expected, found });
    }
    let Array { offset, stride } = batch.palettes;
    if offset % 4 != 0 || stride % 4 != 0 {
        return Err(LayoutError::Fours { offset, stride });
    }
    check_skin(&skin, own)?;
    Ok(Some(skin))
}

fn check_skin(skin: &Skin<'_>, batch: &SkinBatch) -> Result<(), LayoutError> {
    if batch.attributes().iter().all(Option::is_none) {
        return Err(LayoutError::NoOutput);
    }
    let (Range { start, end }, vertex_len) = (batch.vertices.clone(), skin.vertex_len());
    let is_within = match batch.remap {
        // How long it is only the host knows: its buffer must be as long as the range asks.
        Some(_) => vertex_len > 0 || start == end,
        None => end <= vertex_len,
    };
    if start > end || !is_within {
        return Err(LayoutError::VertexRange { start, end, vertex_len });
    }
    if batch.tangents.is_some() && batch.rest.tangents.is_none() && !skin.has_tangents() {
        return Err(LayoutError::NoTangents);
    }
    check_attribute_strides(batch.attributes())
}
