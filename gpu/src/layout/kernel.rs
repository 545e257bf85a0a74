//! Batches of a kernel, and their requirements.

use super::demand::{Demand, Member, array_members, check_part, check_stride, section_member};
use super::error::LayoutError;
use super::resource::{Array, Resource};
use super::stage::Stage;
use sinew_runtime::format::{PartKind, SectionKind};
use sinew_runtime::{KernelMap, Model};

/// Queries of one kernel, and the places of their arrays in the host's buffers. Each query is an
/// instance.
///
/// Offsets and strides count floats. Outputs and confidences share a binding, which spans both
/// arrays. Large batches are cut by this binding, so the arrays are best interleaved query by
/// query.
///
/// A CPU refuses a query or an output that is not finite. A GPU evaluates the query and writes NaN
/// as the confidence, wherever [`KernelMap::evaluate`] returns an error. The outputs of such a
/// query are meaningless.
#[derive(Clone, Debug)]
pub struct KernelBatch {
    /// Number of queries that the buffers have room for. A frame may evaluate only the first ones;
    /// nothing is written for the others.
    pub instance_len: usize,
    /// [`Resource::Queries`]: [`KernelMap::query_len`] floats. With a stride of 0 all instances share one query.
    pub queries: Array,
    /// [`Resource::Out`]: [`KernelMap::result_len`] floats.
    pub outputs: Array,
    /// [`Resource::Out`]: one float, the confidence. `None` omits the confidence, and with it the NaN of a refused query.
    pub confidences: Option<Array>,
}

impl KernelBatch {
    /// Lays out queries without gaps, and outputs one after another, each followed by its
    /// confidence.
    pub fn new(kernel: &KernelMap<'_>, instance_len: usize) -> Self {
        let result_len = kernel.result_len();
        let stride = result_len + 1;
        Self {
            instance_len,
            queries: Array { offset: 0, stride: kernel.query_len() },
            outputs: Array { offset: 0, stride },
            confidences: Some(Array { offset: result_len, stride }),
        }
    }
}

/// Sections that shaders read; each has the name of its member.
const SECTIONS: [SectionKind; 8] = [
    SectionKind::KernelRule,
    SectionKind::Inputs,
    SectionKind::Outputs,
    SectionKind::Features,
    SectionKind::Metric,
    SectionKind::KernelCentres,
    SectionKind::Terms,
    SectionKind::KernelCoefficients,
];

/// Checks a batch against a model and a kernel, and returns its requirements.
pub(super) fn demand(
    model: &Model<impl AsRef<[u8]>>,
    kernel: &KernelMap<'_>,
    batch: &KernelBatch,
) -> Result<Demand, LayoutError> {
    check_part(model, (PartKind::Kernel, kernel.file()), batch.instance_len)?;
    check_stride(Resource::Out, kernel.result_len(), batch.outputs.stride)?;
    if let Some(array) = batch.confidences {
        check_stride(Resource::Out, 1, array.stride)?;
    }
    let counts = kernel.counts();
    let scratch = Array { offset: 0, stride: scratch_len(kernel) };
    let mut arrays = vec![
        (Resource::Queries, batch.queries, kernel.query_len()),
        (Resource::Scratch, scratch, scratch.stride),
        (Resource::Out, batch.outputs, kernel.result_len()),
    ];
    arrays.extend(batch.confidences.map(|array| (Resource::Out, array, 1)));
    let lens = [
        ("input_len", counts.input_len),
        ("output_len", counts.output_len),
        ("feature_len", counts.feature_len),
        ("metric_len", counts.metric_len),
        ("centre_len", counts.centre_len),
        ("term_len", counts.term_len),
        ("value_len", counts.value_len),
    ];
    let lens = lens.map(|(name, len)| (name, Member::Number(len as usize)));
    let sections = SECTIONS.map(|kind| section_member(model, Some(kernel.part()), kind));
    let places = array_members([
        (["scratch_offset", "scratch_stride"], Resource::Scratch, Some(scratch)),
        (["queries_offset", "queries_stride"], Resource::Queries, Some(batch.queries)),
        (["outputs_offset", "outputs_stride"], Resource::Out, Some(batch.outputs)),
        (["confidences_offset", "confidences_stride"], Resource::Out, batch.confidences),
    ]);
    Ok(Demand {
        instance_len: batch.instance_len,
        stages: vec![(Stage::Kernel, 1)],
        arrays,
        members: lens.into_iter().chain(sections).chain(places).collect(),
        blob_bytes: model.blob().len() as u64,
    })
}

/// Counts the scratch floats of an instance: features, metric features, terms of the polynomial,
/// values.
fn scratch_len(kernel: &KernelMap<'_>) -> usize {
    let counts = kernel.counts();
    let lens = [counts.feature_len, counts.metric_len, counts.term_len, counts.value_len];
    lens.into_iter().map(|len| len as usize).sum()
}
