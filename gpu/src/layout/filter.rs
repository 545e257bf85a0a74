//! Batches of a filter, and their requirements.

use super::demand::{
    Demand, Member, array_members, check_part, check_stride, section_member, threads,
};
use super::error::LayoutError;
use super::resource::{Array, Resource};
use super::stage::Stage;
use sinew_runtime::filter::Samples;
use sinew_runtime::format::{PartKind, SectionKind};
use sinew_runtime::{Filter, Model};

/// Signals that a filter makes finer, and their places in the host's buffers. Each signal is an
/// instance.
///
/// Offsets and strides count floats. An image has H rows of W pixels with C channels. Along its
/// columns the image is one signal of H samples with W C lanes. Along its rows the image is H
/// signals of W samples with C lanes. A CPU refuses numbers that are not finite; a GPU evaluates
/// them.
#[derive(Clone, Debug)]
pub struct FilterBatch {
    /// Number of signals that the buffers have room for. A frame may evaluate only the first ones;
    /// nothing is written for the others.
    pub instance_len: usize,
    /// Samples of a signal; at least [`Filter::tap_len`].
    pub sample_len: usize,
    /// Numbers of a sample.
    pub lane_len: usize,
    /// [`Resource::Samples`]: `sample_len * lane_len` floats. With a stride of 0 all signals share their samples.
    pub samples: Array,
    /// [`Resource::Out`]: F times as many floats, F the filter's factor.
    pub outputs: Array,
}

impl FilterBatch {
    /// Lays out signals without gaps.
    pub fn new(filter: &Filter<'_>, samples: Samples) -> Self {
        let Samples { signal_len, sample_len, lane_len } = samples;
        let stride = sample_len.saturating_mul(lane_len);
        Self {
            instance_len: signal_len,
            sample_len,
            lane_len,
            samples: Array { offset: 0, stride },
            outputs: Array { offset: 0, stride: stride.saturating_mul(filter.factor()) },
        }
    }
}

/// Checks a batch against a model and a filter, and returns its requirements.
pub(super) fn demand(
    model: &Model<impl AsRef<[u8]>>,
    filter: &Filter<'_>,
    batch: &FilterBatch,
) -> Result<Demand, LayoutError> {
    check_part(model, (PartKind::Filter, filter.file()), batch.instance_len)?;
    let (least, found) = (filter.tap_len(), batch.sample_len);
    if found < least {
        return Err(LayoutError::Samples { least, found });
    }
    let coarse_len = batch.sample_len.saturating_mul(batch.lane_len);
    let fine_len = coarse_len.saturating_mul(filter.factor());
    if batch.lane_len == 0 {
        return Err(LayoutError::NoLanes);
    }
    check_stride(Resource::Out, fine_len, batch.outputs.stride)?;
    let counts = [
        ("factor", filter.factor()),
        ("tap_len", filter.tap_len()),
        ("sample_len", batch.sample_len),
        ("lane_len", batch.lane_len),
    ];
    let counts = counts.map(|(name, number)| (name, Member::Number(number)));
    let taps = section_member(model, Some(filter.part()), SectionKind::FilterTaps);
    let places = array_members([
        (["samples_offset", "samples_stride"], Resource::Samples, Some(batch.samples)),
        (["outputs_offset", "outputs_stride"], Resource::Out, Some(batch.outputs)),
    ]);
    Ok(Demand {
        instance_len: batch.instance_len,
        stages: vec![(Stage::Filter, threads(fine_len))],
        arrays: vec![
            (Resource::Samples, batch.samples, coarse_len),
            (Resource::Out, batch.outputs, fine_len),
        ],
        members: counts.into_iter().chain([taps]).chain(places).collect(),
        blob_bytes: model.blob().len() as u64,
    })
}
