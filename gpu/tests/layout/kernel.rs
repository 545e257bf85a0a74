//! Batches of a kernel: refusals, cuts, and the places of arrays in chunks.

use crate::common::kernels::odd_batch;
use crate::common::load;
use models::{KernelContent, Pieces};
use sinew_gpu::layout::{
    ALIGNMENT, Array, DeviceLimits, KernelBatch, LayoutError, Plan, Resource, Span, Stage,
};
use sinew_runtime::KernelMap;
use sinew_runtime::format::{PartKind, SectionKind};
use sinew_runtime::kernel::Kernel;

const LIMITS: DeviceLimits = DeviceLimits::DOWNLEVEL;

/// A file of a servo and, behind it, a kernel with every kind of input and output.
fn file() -> Vec<u8> {
    let contents = [KernelContent::servo(), KernelContent::every(Kernel::Gaussian)];
    Pieces::kernels(&contents).bytes()
}

#[test]
fn one_stage_has_a_workgroup_a_query() {
    let bytes = file();
    let model = load(&bytes);
    let kernel = model.named::<KernelMap>("every").unwrap();
    for instance_len in [1, 65_535, 65_536, 200_000] {
        let batch = KernelBatch::new(&kernel, instance_len);
        let plan = Plan::of_kernel(&model, &kernel, &batch, &LIMITS).unwrap();
        assert!(plan.stages().eq([Stage::Kernel]));
        let mut instances = 0;
        for chunk in plan.chunks() {
            let here = chunk.instances.len();
            assert_eq!(chunk.instances.start, instances);
            let found = plan.workgroups(Stage::Kernel, chunk, instance_len);
            assert_eq!(found, Some([1, here as u32]));
            assert_eq!(plan.workgroups(Stage::Skin, chunk, instance_len), None);
            instances += here;
        }
        assert_eq!(instances, instance_len);
    }
}

/// In a chunk's binding, each float of each query is at its place in the whole buffer.
#[test]
fn chunks_keep_the_places_of_the_whole_batch() {
    let bytes = file();
    let model = load(&bytes);
    let kernel = model.named::<KernelMap>("every").unwrap();
    let batch = odd_batch(&kernel, 500);
    let whole = Plan::of_kernel(&model, &kernel, &batch, &LIMITS).unwrap();
    assert_eq!(whole.chunks().len(), 1);
    let storage_binding_bytes = model.blob().len().next_multiple_of(4) as u64;
    let limits = DeviceLimits { storage_binding_bytes, ..LIMITS };
    let plan = Plan::of_kernel(&model, &kernel, &batch, &limits).unwrap();
    assert!(plan.chunks().len() > 2);
    for resource in Resource::ALL.into_iter().filter(|own| *own != Resource::Params) {
        assert_eq!(plan.bytes(resource), whole.bytes(resource), "{resource:?}");
    }
    // Features, metric features, terms and values.
    let scratch = 25 + 5 + 28 + 9;
    let arrays = [
        (Resource::Scratch, "scratch", Array { offset: 0, stride: scratch }, scratch),
        (Resource::Queries, "queries", batch.queries, kernel.query_len()),
        (Resource::Out, "outputs", batch.outputs, kernel.result_len()),
        (Resource::Out, "confidences", batch.confidences.unwrap(), 1),
    ];
    for chunk in plan.chunks() {
        for (resource, name, array, len) in arrays {
            let Span { offset, bytes } = chunk.span(resource).unwrap();
            assert!(offset % ALIGNMENT == 0 && bytes <= storage_binding_bytes, "{resource:?}");
            let param = |what: &str| {
                let name = format!("{name}_{what}");
                let found = chunk.params().iter().find(|(own, _)| *own == name);
                u64::from(found.unwrap().1)
            };
            for (local, instance) in chunk.instances.clone().enumerate() {
                let bound = offset / 4 + param("offset") + local as u64 * param("stride");
                assert_eq!(bound, (array.offset + instance * array.stride) as u64, "{name}");
                assert!(4 * (bound + len as u64) <= offset + bytes, "{name}");
            }
        }
    }
}

#[test]
fn counts_and_sections_are_those_of_the_kernel() {
    let bytes = file();
    let model = load(&bytes);
    for (part, kernel) in model.all::<KernelMap>().enumerate() {
        let batch = KernelBatch { confidences: None, ..KernelBatch::new(&kernel, 2) };
        let plan = Plan::of_kernel(&model, &kernel, &batch, &LIMITS).unwrap();
        let params = plan.chunks()[0].params();
        let param = |name: &str| params.iter().find(|(own, _)| *own == name).unwrap().1;
        let counts = kernel.counts();
        assert_eq!(
            ["input_len", "feature_len", "metric_len", "centre_len", "term_len"].map(param),
            [
                counts.input_len,
                counts.feature_len,
                counts.metric_len,
                counts.centre_len,
                counts.term_len
            ]
        );
        assert_eq!(param("confidences_offset"), u32::MAX);
        for kind in [SectionKind::KernelRule, SectionKind::Inputs, SectionKind::KernelCoefficients]
        {
            let mut sections = model.sections().map(|section| section.row);
            let own = (part as u16, kind.number());
            let row = sections.find(|row| (row.part, row.kind) == own).unwrap();
            assert_eq!(4 * param(kind.name()), row.offset, "{kind:?}");
        }
    }
}

#[test]
fn a_batch_that_does_not_fit_the_kernel_is_refused() {
    let bytes = file();
    let model = load(&bytes);
    let kernel = model.named::<KernelMap>("every").unwrap();
    let other = Pieces::kernels(&[KernelContent::servo()]).bytes();
    let other = load(&other);
    let planned =
        |kernel: &KernelMap<'_>, limits: &DeviceLimits, edit: &dyn Fn(&mut KernelBatch)| {
            let mut batch = KernelBatch::new(kernel, 4);
            edit(&mut batch);
            Plan::of_kernel(&model, kernel, &batch, limits).map(drop)
        };
    let refused = |edit: &dyn Fn(&mut KernelBatch)| planned(&kernel, &LIMITS, edit).unwrap_err();
    assert_eq!(planned(&kernel, &LIMITS, &|_| {}), Ok(()));
    let foreign = planned(&other.first::<KernelMap>().unwrap(), &LIMITS, &|_| {});
    assert_eq!(foreign, Err(LayoutError::OtherFile { part: PartKind::Kernel }));
    assert_eq!(foreign.unwrap_err().to_string(), "the kernel is of another file than the model");
    assert_eq!(refused(&|b| b.instance_len = 0), LayoutError::NoInstances);
    let (resource, least) = (Resource::Out, kernel.result_len());
    let short = LayoutError::Stride { resource, least, found: least - 1 };
    assert_eq!(refused(&|b| b.outputs.stride = least - 1), short);
    let none = LayoutError::Stride { resource, least: 1, found: 0 };
    assert_eq!(refused(&|b| b.confidences.as_mut().unwrap().stride = 0), none);
    assert_eq!(planned(&kernel, &LIMITS, &|b| b.queries.stride = 0), Ok(()));
    let far = refused(&|b| b.queries.offset = usize::MAX);
    assert!(matches!(far, LayoutError::Binding { resource: Resource::Queries, .. }));

    let found = model.blob().len().next_multiple_of(4) as u64;
    let small = DeviceLimits { storage_binding_bytes: found - 1, ..LIMITS };
    let limit = LayoutError::Binding { resource: Resource::Blob, limit: found - 1, found };
    assert_eq!(planned(&kernel, &small, &|_| {}), Err(limit));
    let few = DeviceLimits { storage_buffers: 3, ..LIMITS };
    assert!(matches!(planned(&kernel, &few, &|_| {}), Err(LayoutError::Device { .. })));
}
