//! Batches of an envelope and its skin: stages, workgroups, cuts, and the places of arrays in
//! chunks.

use crate::common::{GOLDEN, GOLDEN_STRETCH, hosted_batch, load, parts};
use sinew_gpu::layout::{
    ALIGNMENT, Array, Attribute, Batch, Chunk, DeviceLimits, Plan, Resource, SkinBatch, Span,
    Stage, WORKGROUP,
};
use sinew_runtime::envelope::ScratchLayout;
use sinew_runtime::{Envelope, Skin};

pub(super) const ROTATIONAL: &[u8] = GOLDEN[0];
pub(super) const KERNEL: &[u8] = GOLDEN[1];

/// A device with large bindings.
pub(super) const LARGE: DeviceLimits =
    DeviceLimits { storage_binding_bytes: 1 << 32, ..DeviceLimits::DOWNLEVEL };

/// Positions and tangents vertex by vertex with gaps; normals of a vertex for all instances side by
/// side.
pub(super) fn scattered(envelope: &Envelope<'_>, skin: &Skin<'_>, instance_len: usize) -> Batch {
    let attribute =
        |offset, stride, instance_stride| Some(Attribute { offset, stride, instance_stride });
    let after = 5 + 190 * instance_len;
    let skin = SkinBatch {
        vertices: 3..20,
        positions: attribute(5, 11, 190),
        normals: attribute(after, 7 * instance_len, 7),
        tangents: attribute(8, 11, 190),
        ..SkinBatch::new(skin)
    };
    Batch {
        instance_len,
        poses: Array { offset: 7, stride: 1061 },
        curves: Array { offset: 9, stride: envelope.curve_len() + 5 },
        palettes: Array { offset: 132, stride: 12 * envelope.palette_len() + 4 },
        confidences: Some(Array { offset: 3, stride: 2 }),
        skin: Some(skin),
    }
}

fn param(chunk: &Chunk, name: &str) -> u64 {
    let found = chunk.params().iter().find(|(own, _)| *own == name);
    found.unwrap_or_else(|| panic!("there is no {name}")).1.into()
}

#[test]
fn stages_follow_the_predictor() {
    use Stage::{Confidence, Correction, Features, Gradients, Joints, Palette, Polar, Skin};
    let stages = |bytes, skinned: bool| {
        let model = load(bytes);
        let (envelope, skin) = parts(&model);
        let mut batch = Batch::skinned(&envelope, &skin, 2);
        if !skinned {
            batch = Batch { confidences: None, ..Batch::palettes(&envelope, 2) };
        }
        let plan = Plan::new(&model, &envelope, &batch, &LARGE).unwrap();
        plan.stages().collect::<Vec<_>>()
    };
    assert_eq!(stages(ROTATIONAL, true), [Gradients, Palette, Skin, Confidence]);
    assert_eq!(stages(KERNEL, true), [Joints, Features, Correction, Skin, Confidence]);
    assert_eq!(stages(KERNEL, false), [Joints, Features, Correction]);
    let [rotational, kernel] = GOLDEN_STRETCH;
    assert_eq!(stages(rotational, true), [Polar, Gradients, Palette, Skin, Confidence]);
    assert_eq!(stages(kernel, false), [Polar, Joints, Features, Correction]);
}

#[test]
fn stages_bind_four_storage_buffers_at_most() {
    for stage in Stage::ALL {
        let [params, storage @ ..] = stage.bindings() else { panic!("{stage:?} binds nothing") };
        assert_eq!(params.resource, Resource::Params);
        assert!(storage.len() <= 4, "{stage:?}");
    }
}

/// In a chunk's binding, each word of each instance is at its place in the whole buffer.
#[test]
fn chunks_keep_the_places_of_the_whole_batch() {
    for bytes in GOLDEN.into_iter().chain(GOLDEN_STRETCH) {
        let model = load(bytes);
        let (envelope, skin) = parts(&model);
        let blob_bytes = model.blob().len() as u64;
        for batch in [scattered(&envelope, &skin, 100), hosted_batch(&envelope, &skin, 100)] {
            let whole = Plan::new(&model, &envelope, &batch, &LARGE).unwrap();
            assert_eq!(whole.chunks().len(), 1);
            let mut counts = Vec::new();
            for limit in [blob_bytes, blob_bytes + 4096, 1 << 18, 1 << 32] {
                let limits = DeviceLimits { storage_binding_bytes: limit.max(130_000), ..LARGE };
                let plan = Plan::new(&model, &envelope, &batch, &limits).unwrap();
                counts.push(plan.chunks().len());
                let mut next = 0;
                for chunk in plan.chunks() {
                    assert_eq!(chunk.instances.start, next);
                    next = chunk.instances.end;
                    check_chunk((&envelope, &skin), &batch, chunk, limits.storage_binding_bytes);
                }
                assert_eq!(next, 100);
                for resource in Resource::ALL.into_iter().filter(|r| *r != Resource::Params) {
                    assert_eq!(plan.bytes(resource), whole.bytes(resource), "{resource:?}");
                }
            }
            assert!(counts[0] > 1 && counts.last() == Some(&1), "{counts:?}");
        }
    }
}

fn check_chunk(
    (envelope, own): (&Envelope<'_>, &Skin<'_>),
    batch: &Batch,
    chunk: &Chunk,
    limit: u64,
) {
    for resource in Resource::ALL {
        let Some(Span { offset, bytes }) = chunk.span(resource) else { continue };
        assert!(offset % ALIGNMENT == 0 && bytes % 4 == 0 && bytes <= limit, "{resource:?}");
    }
    let skin = batch.skin.as_ref().expect("it skins");
    let scratch = ScratchLayout::at_once(envelope).len;
    let (v, rest) = (own.vertex_len(), skin.rest);
    let curves = Some(batch.curves).filter(|_| envelope.curve_len() > 0);
    let arrays = [
        (Resource::Scratch, "scratch", Some(Array { offset: 0, stride: scratch }), scratch),
        (Resource::Poses, "poses", Some(batch.poses), 12 * envelope.joint_len()),
        (Resource::Curves, "curves", curves, envelope.curve_len()),
        (Resource::Palettes, "palettes", Some(batch.palettes), 12 * envelope.palette_len()),
        (Resource::Confidences, "confidences", batch.confidences, 1),
        (Resource::Host, "host_remap", skin.remap, skin.vertices.end),
        (Resource::Host, "host_positions", rest.positions, 3 * v),
        (Resource::Host, "host_normals", rest.normals, 3 * v),
        (Resource::Host, "host_tangents", rest.tangents, 4 * v),
    ];
    for (resource, name, array, len) in arrays {
        let [offset, stride] =
            ["offset", "stride"].map(|what| param(chunk, &format!("{name}_{what}")));
        let Some(array) = array else {
            assert_eq!(offset, u64::from(u32::MAX), "{name}");
            continue;
        };
        let span = chunk.span(resource).expect("it is bound");
        for (local, instance) in chunk.instances.clone().enumerate() {
            let bound = span.offset / 4 + offset + local as u64 * stride;
            assert_eq!(bound, (array.offset + instance * array.stride) as u64, "{name}");
            assert!(4 * (bound + len as u64) <= span.offset + span.bytes, "{name}");
        }
    }
    let attributes = [
        ("positions", skin.positions, 3),
        ("normals", skin.normals, 3),
        ("tangents", skin.tangents, 4),
    ];
    for (name, attribute, len) in attributes {
        let of = |what: &str| param(chunk, &format!("{name}_{what}"));
        let Some(Attribute { offset, stride, instance_stride }) = attribute else {
            assert_eq!(of("offset"), u64::from(u32::MAX), "{name}");
            continue;
        };
        let span = chunk.span(Resource::Out).expect("it is bound");
        for (local, instance) in chunk.instances.clone().enumerate() {
            for i in 0..skin.vertices.len() {
                let local = of("offset") + local as u64 * of("instance_stride");
                let bound = span.offset / 4 + local + i as u64 * of("stride");
                let expected = offset + instance * instance_stride + i * stride;
                assert_eq!(bound, expected as u64, "{name}");
                assert!(4 * (bound + len) <= span.offset + span.bytes, "{name}");
            }
        }
    }
}

#[test]
fn large_chunks_without_gaps_do_not_meet() {
    let model = load(KERNEL);
    let (envelope, skin) = parts(&model);
    let limits = DeviceLimits { storage_binding_bytes: 300_000, ..LARGE };
    let batch = Batch::skinned(&envelope, &skin, 1000);
    let plan = Plan::new(&model, &envelope, &batch, &limits).unwrap();
    assert!(plan.chunks().len() > 2);
    for pair in plan.chunks().windows(2) {
        for resource in [Resource::Poses, Resource::Palettes, Resource::Scratch, Resource::Out] {
            let [a, b] = [0, 1].map(|i| pair[i].span(resource).unwrap());
            assert_eq!(a.offset + a.bytes, b.offset, "{resource:?}");
        }
    }
}

#[test]
fn a_missing_resource_is_bound_to_the_blob() {
    let model = load(ROTATIONAL);
    let (envelope, skin) = parts(&model);
    let bound = |batch: Batch| {
        let plan = Plan::new(&model, &envelope, &batch, &LARGE).unwrap();
        let (resource, span) = plan.chunks()[0].bound(Resource::Host);
        assert_eq!(span, plan.chunks()[0].span(resource));
        (resource, plan.bytes(Resource::Host))
    };
    let (resource, bytes) = bound(hosted_batch(&envelope, &skin, 2));
    assert!(resource == Resource::Host && bytes > 0);
    assert_eq!(bound(Batch::skinned(&envelope, &skin, 2)), (Resource::Blob, 0));
    // The blob replaces `Host`, so no stage may write to `Host`.
    for binding in Stage::ALL.into_iter().flat_map(Stage::bindings) {
        assert!(!binding.writable || binding.resource != Resource::Host);
    }
}

#[test]
fn params_hold_the_blocks_of_all_chunks() {
    let model = load(KERNEL);
    let (envelope, skin) = parts(&model);
    let limits = DeviceLimits { storage_binding_bytes: 130_000, ..LARGE };
    let plan = Plan::new(&model, &envelope, &scattered(&envelope, &skin, 100), &limits).unwrap();
    let bytes = plan.params();
    assert_eq!(bytes.len() as u64, plan.bytes(Resource::Params));
    assert!(plan.chunks().len() > 1);
    for chunk in plan.chunks() {
        let span = chunk.span(Resource::Params).unwrap();
        let block = &bytes[span.offset as usize..][..span.bytes as usize];
        let words = block.as_chunks::<4>().0.iter().map(|le| u32::from_le_bytes(*le));
        let values: Vec<_> = chunk.params().iter().map(|(_, value)| *value).collect();
        assert!(words.take(values.len()).eq(values.iter().copied()));
        assert_eq!(span.bytes, (4 * values.len() as u64).next_multiple_of(16));
    }
}

#[test]
fn every_instance_has_workgroups_of_its_own() {
    for bytes in GOLDEN.into_iter().chain(GOLDEN_STRETCH) {
        let model = load(bytes);
        let (envelope, skin) = parts(&model);
        for instance_len in [1, 3, 65_535, 65_536, 400_001] {
            let mut batch = Batch::skinned(&envelope, &skin, instance_len);
            // The last of three workgroups has one vertex.
            let own = batch.skin.as_mut().unwrap();
            (own.remap, own.vertices) = (Some(Array { offset: 0, stride: 0 }), 5..134);
            let plan = Plan::new(&model, &envelope, &batch, &LARGE).unwrap();
            // All workgroups of an axis; if there are more instances, the largest number whose
            // spans do not overlap.
            let most = if instance_len > 65_535 { 65_472 } else { 65_535 };
            assert_eq!(plan.chunks().len(), instance_len.div_ceil(most));
            let mut instances = 0;
            for chunk in plan.chunks() {
                let threads = |len: usize| (len as u32).div_ceil(WORKGROUP);
                let here = chunk.instances.len();
                assert!(here <= 65_535);
                for (stage, x) in [
                    (Stage::Polar, threads(envelope.joint_len())),
                    (Stage::Gradients, 1),
                    (Stage::Palette, threads(envelope.proxy_len())),
                    (Stage::Joints, threads(envelope.palette_len())),
                    (Stage::Features, threads(envelope.joint_len().max(envelope.curve_len()))),
                    (Stage::Correction, envelope.group_len() as u32),
                    (Stage::Skin, 3),
                    (Stage::Confidence, 1),
                ] {
                    let planned = plan.stages().any(|own| own == stage);
                    let found = plan.workgroups(stage, chunk, instance_len);
                    assert_eq!(found, planned.then_some([x, here as u32]), "{stage:?}");
                }
                instances += here;
            }
            assert_eq!(instances, instance_len);
        }
    }
}

#[test]
fn fewer_instances_take_fewer_workgroups() {
    let model = load(KERNEL);
    let (envelope, skin) = parts(&model);
    let limits = DeviceLimits { storage_binding_bytes: 50_000, ..LARGE };
    let batch = Batch::skinned(&envelope, &skin, 100);
    let plan = Plan::new(&model, &envelope, &batch, &limits).unwrap();
    let [first, second, ..] = plan.chunks() else { panic!("it is cut") };
    let workgroups = |chunk, len| plan.workgroups(Stage::Skin, chunk, len);
    let len = first.instances.len();
    assert_eq!(workgroups(first, len), workgroups(first, 100));
    assert_eq!(workgroups(first, 1), Some([1, 1]));
    assert_eq!(workgroups(second, len), None);
    assert_eq!(workgroups(second, len + 1), Some([1, 1]));
}

#[test]
fn an_empty_range_is_skinned_by_no_stage() {
    let model = load(KERNEL);
    let (envelope, skin) = parts(&model);
    for start in [0, 24] {
        let mut batch = hosted_batch(&envelope, &skin, 2);
        let own = batch.skin.as_mut().unwrap();
        (own.vertices, own.remap) = (start..start, None);
        let plan = Plan::new(&model, &envelope, &batch, &LARGE).unwrap();
        assert!(plan.stages().all(|stage| stage != Stage::Skin));
        assert_eq!([Resource::Host, Resource::Out].map(|own| plan.bytes(own)), [0; 2]);
        // The host's own shader still finds the skin.
        let chunk = &plan.chunks()[0];
        assert_eq!(param(chunk, "influence_len"), skin.influence_len() as u64);
        assert!(param(chunk, "influence_weights") > 0);
    }
}
