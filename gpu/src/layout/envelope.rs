//! Batches of an envelope, and of a skin that follows it.

use super::demand::{
    Attributes, Demand, Member, array_members, attribute_arrays, attribute_members,
    check_attributes, check_part, check_stride, packed_attributes, section_member, threads,
};
use super::error::LayoutError;
use super::resource::{Array, Attribute, Resource};
use super::stage::Stage;
use sinew_runtime::envelope::ScratchLayout;
use sinew_runtime::format::{PartKind, SectionKind};
use sinew_runtime::{Envelope, Model, PartLayout, Skin};
use std::ops::Range;

/// Instances of one model, and the places of their arrays in the host's buffers.
///
/// Offsets and strides count words of 4 bytes: floats, and indices of a remap. Instances may be in
/// any order, but no two may write to the same word; this is not checked.
#[derive(Clone, Debug)]
pub struct Batch {
    /// Number of instances that the buffers have room for. A frame may evaluate only the first
    /// ones; nothing is written for the others.
    pub instance_len: usize,
    /// [`Resource::Poses`]: 12 J floats an instance. With a stride of 0 all instances share one pose.
    pub poses: Array,
    /// [`Resource::Curves`]: C finite floats an instance, in the order of [`Envelope::curve_name`]. With a
    /// stride of 0 all instances share their curves.
    pub curves: Array,
    /// [`Resource::Palettes`]: 12 floats for each transform. If the batch skins, offset and stride must
    /// be multiples of 4.
    pub palettes: Array,
    /// [`Resource::Confidences`]: one float an instance; `None` omits the stage.
    pub confidences: Option<Array>,
    /// The skin to evaluate; `None` for palettes only.
    pub skin: Option<SkinBatch>,
}

/// Vertices to skin and places of the results: a [`sinew_runtime::SkinJob`] for every instance.
#[derive(Clone, Debug)]
pub struct SkinBatch {
    /// [`Skin::layout`] of a skin that follows the batch's envelope.
    pub skin: PartLayout,
    /// Vertices of the remap, or of the skin if there is no remap. No stage skins an empty range,
    /// but [`Resource::Params`] still tells the host's own shader the places of the skin's arrays.
    pub vertices: Range<usize>,
    /// In [`Resource::Host`], u32: maps each engine vertex to the skin vertex that it copies. A CPU
    /// refuses an index outside the mesh; a GPU uses the last vertex instead.
    pub remap: Option<Array>,
    /// The host's rest mesh, in place of the file's.
    pub rest: Rest,
    /// Place of the positions: 3 floats, model space.
    pub positions: Option<Attribute>,
    /// Place of the normals: 3 floats, of length 1.
    pub normals: Option<Attribute>,
    /// Place of the tangents: 3 floats of length 1, then the handedness.
    pub tangents: Option<Attribute>,
}

/// The host's rest mesh in [`Resource::Host`], indexed by the skin's own vertices. An attribute
/// that is `None` comes from the file. With a stride of 0 all instances share the attribute.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rest {
    /// V positions of 3 floats.
    pub positions: Option<Array>,
    /// V normals of 3 floats, of length 1.
    pub normals: Option<Array>,
    /// V tangents of 4 floats: a vector of length 1, then the handedness.
    pub tangents: Option<Array>,
}

impl Batch {
    /// Lays out palettes and confidences without gaps, and skins nothing.
    pub fn palettes(envelope: &Envelope<'_>, instance_len: usize) -> Self {
        Self {
            instance_len,
            poses: Array { offset: 0, stride: 12 * envelope.joint_len() },
            curves: Array { offset: 0, stride: envelope.curve_len() },
            palettes: Array { offset: 0, stride: 12 * envelope.palette_len() },
            confidences: Some(Array { offset: 0, stride: 1 }),
            skin: None,
        }
    }

    /// Lays out palettes and confidences without gaps, and a whole skin as [`SkinBatch::new`] does.
    pub fn skinned(envelope: &Envelope<'_>, skin: &Skin<'_>, instance_len: usize) -> Self {
        Self { skin: Some(SkinBatch::new(skin)), ..Self::palettes(envelope, instance_len) }
    }
}

impl SkinBatch {
    /// Lays out a whole skin without gaps. For each instance: its V positions, its V normals and,
    /// if the skin has tangents, its V tangents.
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

    /// Lists the arrays in [`Resource::Host`] with the words of one instance: the remap up to the
    /// last skinned vertex, then the rest mesh of V vertices.
    fn host(&self, vertex_len: usize) -> [(Option<Array>, usize); 4] {
        let Rest { positions, normals, tangents } = self.rest;
        let of = |floats: usize| vertex_len.saturating_mul(floats);
        [(self.remap, self.vertices.end), (positions, of(3)), (normals, of(3)), (tangents, of(4))]
    }
}

/// Sections that shaders read; each has the name of its member. `true` marks sections of the skin,
/// `false` those of the envelope.
const SECTIONS: [(bool, SectionKind); 18] = [
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
    (false, SectionKind::StretchRanges),
    (false, SectionKind::KeyStretches),
    (false, SectionKind::CurveRanges),
    (false, SectionKind::HelperPlaces),
];

/// Checks a batch against a model and an envelope, and returns its requirements.
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
        .chain(inner(envelope, &scratch))
        .chain(outer(batch, &scratch));
    Ok(Demand {
        instance_len: batch.instance_len,
        stages: stages(envelope, batch),
        arrays: arrays(envelope, skin.as_ref(), batch, &scratch),
        members: members.collect(),
        blob_bytes: model.blob().len() as u64,
    })
}

/// Lists the stages of a batch in the order of [`Stage::ALL`], with the workgroups of one instance.
/// A stage that the predictor does not need has 0 workgroups.
fn stages(envelope: &Envelope<'_>, batch: &Batch) -> Vec<(Stage, u64)> {
    let predictor = envelope.predictor();
    let vertex_len = batch.skin.as_ref().map_or(0, |skin| skin.vertices.len());
    let reconstructs = u64::from(predictor.reconstructs());
    let corrects = u64::from(predictor.corrects());
    let has_maps = envelope.group_len() > 0;
    let splits = envelope.stretches() && (predictor.reconstructs() || has_maps);
    let feature_threads = threads(envelope.joint_len().max(envelope.curve_len()));
    vec![
        (Stage::Polar, u64::from(splits) * threads(envelope.joint_len())),
        (Stage::Gradients, reconstructs),
        (Stage::Palette, reconstructs * threads(envelope.proxy_len())),
        (Stage::Joints, (1 - reconstructs) * threads(envelope.palette_len())),
        (Stage::Features, corrects * u64::from(has_maps) * feature_threads),
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
        (Resource::Curves, batch.curves, envelope.curve_len()),
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

/// Lists the members that hold counts.
fn counts(
    envelope: &Envelope<'_>,
    skin: Option<&Skin<'_>>,
    batch: &Batch,
) -> [(&'static str, Member); 12] {
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
        ("curve_len", envelope.curve_len()),
        ("root", envelope.root()),
        ("predictor", usize::from(envelope.predictor().number())),
        ("helper_kind", usize::from(envelope.helper_kind().number())),
    ]
    .map(number)
}

/// Lists the offsets of arrays in the scratch of an instance.
fn inner(envelope: &Envelope<'_>, scratch: &ScratchLayout) -> [(&'static str, Member); 10] {
    // The curves are the last features.
    let of_curves = envelope.counts().feature_len() - envelope.curve_len();
    [
        ("relative", scratch.relative),
        ("rotations", scratch.rotations),
        ("gradients", scratch.gradients),
        ("turns", scratch.turns),
        ("strains", scratch.strains),
        ("features", scratch.features),
        ("curve_features", scratch.features + of_curves),
        ("group_confidences", scratch.confidences),
        ("group_scratch", scratch.groups),
        ("group_stride", scratch.group_stride),
    ]
    .map(number)
}

/// Lists the offsets and strides of arrays in their bindings.
fn outer(batch: &Batch, scratch: &ScratchLayout) -> Vec<(&'static str, Member)> {
    let own = batch.skin.as_ref();
    let rest = own.map(|own| own.rest).unwrap_or_default();
    let scratch = Some(Array { offset: 0, stride: scratch.len });
    let remap = own.and_then(|own| own.remap);
    let arrays = array_members([
        (["scratch_offset", "scratch_stride"], Resource::Scratch, scratch),
        (["poses_offset", "poses_stride"], Resource::Poses, Some(batch.poses)),
        (["curves_offset", "curves_stride"], Resource::Curves, Some(batch.curves)),
        (["palettes_offset", "palettes_stride"], Resource::Palettes, Some(batch.palettes)),
        (["confidences_offset", "confidences_stride"], Resource::Confidences, batch.confidences),
        (["host_remap_offset", "host_remap_stride"], Resource::Host, remap),
        (["host_positions_offset", "host_positions_stride"], Resource::Host, rest.positions),
        (["host_normals_offset", "host_normals_stride"], Resource::Host, rest.normals),
        (["host_tangents_offset", "host_tangents_stride"], Resource::Host, rest.tangents),
    ]);
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
    check_part(model, (PartKind::Envelope, envelope.file()), batch.instance_len)?;
    check_stride(Resource::Palettes, 12 * envelope.palette_len(), batch.palettes.stride)?;
    if let Some(array) = batch.confidences {
        check_stride(Resource::Confidences, 1, array.stride)?;
    }
    let Some(own) = &batch.skin else { return Ok(None) };
    let skin = own.skin.open::<Skin>(model.as_bytes());
    let skin = skin.ok_or(LayoutError::OtherFile { part: PartKind::Skin })?;
    let (expected, found) = (envelope.part(), skin.envelope_part());
    if found != Some(expected) {
        return Err(LayoutError::OtherEnvelope { expected, found });
    }
    let Array { offset, stride } = batch.palettes;
    if offset % 4 != 0 || stride % 4 != 0 {
        return Err(LayoutError::Fours { offset, stride });
    }
    let (vertices, vertex_len) = (own.vertices.clone(), skin.vertex_len());
    let is_within = match own.remap {
        // Only the host knows the length of the remap; `Plan::check_buffers` requires a buffer that
        // holds the range.
        Some(_) => vertex_len > 0 || vertices.start == vertices.end,
        None => vertices.end <= vertex_len,
    };
    let has_tangents = own.rest.tangents.is_some() || skin.has_tangents();
    check_attributes(own.attributes(), vertices, vertex_len, is_within, has_tangents)?;
    Ok(Some(skin))
}
