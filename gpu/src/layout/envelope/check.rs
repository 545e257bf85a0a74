//! Whether a batch is one of a model's envelope at all.

use super::batch::{Batch, SkinBatch};
use crate::layout::array::Array;
use crate::layout::demand::check_stride;
use crate::layout::error::LayoutError;
use crate::layout::resource::Resource;
use sinew_runtime::format::PartKind;
use sinew_runtime::{Envelope, Model, Skin};
use std::ops::Range;

/// Checks a batch against a model and an envelope, and opens its skin.
pub(super) fn check<'a>(
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
    if batch.attributes().iter().all(|(attribute, _)| attribute.is_none()) {
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
    let written = batch.attributes().into_iter();
    let mut written = written.filter_map(|(own, least)| Some((own?.stride, least)));
    written.try_for_each(|(stride, least)| check_stride(Resource::Out, least, stride))
}
