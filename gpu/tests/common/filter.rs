//! A batch of a filter, beside those of envelopes, kernels and shapes.

use super::load;
use models::{FilterContent, Pieces};
use sinew_gpu::layout::{DeviceLimits, FilterBatch, Plan};
use sinew_runtime::filter::Samples;

/// Plans three signals of a filter; returns the blob beside.
pub(crate) fn filter_plan(limits: &DeviceLimits) -> (Plan, Vec<u8>) {
    let bytes = Pieces::filter(&FilterContent::sample(2, 5)).bytes();
    let model = load(&bytes);
    let filter = model.filter().unwrap();
    let samples = Samples { signal_len: 3, sample_len: 9, lane_len: 2 };
    let batch = FilterBatch::new(&filter, samples);
    let plan = Plan::of_filter(&model, &filter, &batch, limits).unwrap();
    (plan, model.blob().to_vec())
}
