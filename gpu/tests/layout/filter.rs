//! Batches of filters: refusals, workgroups, and the places of arrays in chunks.

use crate::common::load;
use models::{FilterContent, Pieces};
use sinew_gpu::layout::{
    Array, DeviceLimits, FilterBatch, LayoutError, Plan, Resource, Span, Stage,
};
use sinew_runtime::Filter;
use sinew_runtime::filter::Samples;
use sinew_runtime::format::{PartKind, SectionKind};

const LIMITS: DeviceLimits = DeviceLimits::DOWNLEVEL;
const SAMPLES: Samples = Samples { signal_len: 5, sample_len: 32, lane_len: 3 };

fn file() -> Vec<u8> {
    Pieces::filter(&FilterContent::sample(2, 5)).bytes()
}

#[test]
fn a_thread_is_a_number() {
    let bytes = file();
    let model = load(&bytes);
    let filter = model.first::<Filter>().unwrap();
    for (sample_len, lane_len, workgroups) in [(32, 1, 1), (33, 1, 2), (5, 64, 10), (32, 3, 3)] {
        let samples = Samples { sample_len, lane_len, ..SAMPLES };
        let batch = FilterBatch::new(&filter, samples);
        let plan = Plan::of_filter(&model, &filter, &batch, &LIMITS).unwrap();
        assert!(plan.stages().eq([Stage::Filter]));
        let chunk = &plan.chunks()[0];
        assert_eq!(plan.workgroups(Stage::Filter, chunk, 5), Some([workgroups, 5]));
        let floats = |resource| plan.bytes(resource) / 4;
        let len = 5 * sample_len as u64 * lane_len as u64;
        assert_eq!([Resource::Samples, Resource::Out].map(floats), [len, 2 * len]);
    }
}

#[test]
fn counts_and_sections_are_those_of_the_filter() {
    let bytes = file();
    let model = load(&bytes);
    let filter = model.first::<Filter>().unwrap();
    let batch = FilterBatch::new(&filter, SAMPLES);
    let plan = Plan::of_filter(&model, &filter, &batch, &LIMITS).unwrap();
    let params = plan.chunks()[0].params();
    let param = |name: &str| params.iter().find(|(own, _)| *own == name).unwrap().1;
    assert_eq!(["factor", "tap_len", "sample_len", "lane_len"].map(param), [2, 5, 32, 3]);
    assert_eq!(["samples_stride", "outputs_stride"].map(param), [96, 192]);
    let mut sections = model.sections().map(|section| section.row);
    let taps = sections.find(|row| row.kind == SectionKind::FilterTaps.number()).unwrap();
    assert_eq!(4 * param("filter_taps"), taps.offset);
}

/// In a chunk's binding, each number of each signal is at its place in the whole buffer.
#[test]
fn chunks_keep_the_places_of_the_whole_batch() {
    let bytes = file();
    let model = load(&bytes);
    let filter = model.first::<Filter>().unwrap();
    let samples = Samples { signal_len: 300, ..SAMPLES };
    let new = FilterBatch::new(&filter, samples);
    let batch = FilterBatch { outputs: Array { offset: 3, stride: 200 }, ..new };
    let limits = DeviceLimits { storage_binding_bytes: 16 << 10, ..LIMITS };
    let plan = Plan::of_filter(&model, &filter, &batch, &limits).unwrap();
    assert!(plan.chunks().len() > 5);
    for chunk in plan.chunks() {
        let param = |name: &str| {
            let found = chunk.params().iter().find(|(own, _)| *own == name).unwrap().1;
            found as usize
        };
        for (resource, array, name) in [
            (Resource::Samples, batch.samples, "samples"),
            (Resource::Out, batch.outputs, "outputs"),
        ] {
            let Span { offset, bytes } = chunk.span(resource).unwrap();
            assert!(bytes <= 16 << 10);
            let first = array.offset + chunk.instances.start * array.stride;
            assert_eq!(offset as usize / 4 + param(&format!("{name}_offset")), first);
            assert_eq!(param(&format!("{name}_stride")), array.stride);
        }
    }
}

#[test]
fn a_batch_that_does_not_fit_the_filter_is_refused() {
    let bytes = file();
    let model = load(&bytes);
    let filter = model.first::<Filter>().unwrap();
    let new = FilterBatch::new(&filter, SAMPLES);
    let refused = |batch: &FilterBatch, limits: &DeviceLimits| {
        Plan::of_filter(&model, &filter, batch, limits).unwrap_err()
    };
    let none = FilterBatch { instance_len: 0, ..new.clone() };
    assert_eq!(refused(&none, &LIMITS), LayoutError::NoInstances);
    let short = FilterBatch { sample_len: 4, ..new.clone() };
    assert_eq!(refused(&short, &LIMITS), LayoutError::Samples { least: 5, found: 4 });
    let empty = FilterBatch { lane_len: 0, ..new.clone() };
    assert_eq!(refused(&empty, &LIMITS), LayoutError::NoLanes);
    let meeting = FilterBatch { outputs: Array { offset: 0, stride: 191 }, ..new.clone() };
    let stride = LayoutError::Stride { resource: Resource::Out, least: 192, found: 191 };
    assert_eq!(refused(&meeting, &LIMITS), stride);
    let many = FilterBatch::new(&filter, Samples { lane_len: 65_536, ..SAMPLES });
    let found = 65_536;
    let workgroups = LayoutError::Workgroups { stage: Stage::Filter, limit: 65_535, found };
    assert_eq!(refused(&many, &LIMITS), workgroups);
    let other = Pieces::filter(&FilterContent::sample(3, 5)).bytes();
    let other = load(&other);
    let error = Plan::of_filter(&other, &filter, &new, &LIMITS).unwrap_err();
    assert_eq!(error, LayoutError::OtherFile { part: PartKind::Filter });
    let messages = [
        (LayoutError::Samples { least: 5, found: 4 }, "signals of 4 samples, expected at least 5"),
        (LayoutError::NoLanes, "samples of no lane"),
    ];
    messages.iter().for_each(|(error, text)| assert_eq!(error.to_string(), *text));
}
