//! What a batch of an envelope asks for.

use super::batch::{Batch, SkinBatch};
use super::check::check;
use crate::layout::array::Array;
use crate::layout::attribute::{Attribute, attribute_members};
use crate::layout::demand::{Demand, Member, array_members, section_member, threads};
use crate::layout::error::LayoutError;
use crate::layout::resource::Resource;
use crate::layout::stage::Stage;
use sinew_runtime::envelope::ScratchLayout;
use sinew_runtime::format::SectionKind;
use sinew_runtime::{Envelope, Model, Skin};

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
pub(in crate::layout) fn demand(
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
    let Some(last) = own.vertices.len().checked_sub(1) else { return out };
    let host = own.host(skin.map_or(0, |skin| skin.vertex_len())).into_iter();
    out.extend(host.filter_map(|(array, len)| Some((Resource::Host, array?, len))));
    out.extend(own.attributes().into_iter().filter_map(|(attribute, len)| {
        let own = attribute?;
        let len = last.saturating_mul(own.stride).saturating_add(len);
        Some((Resource::Out, own.array(), len))
    }));
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
    let attribute = |of: fn(&SkinBatch) -> Option<Attribute>| own.and_then(of);
    let [positions, normals, tangents] = [
        attribute(|own| own.positions),
        attribute(|own| own.normals),
        attribute(|own| own.tangents),
    ];
    arrays.chain(attribute_members(positions, normals, tangents)).collect()
}

fn number((name, number): (&'static str, usize)) -> (&'static str, Member) {
    (name, Member::Number(number))
}
