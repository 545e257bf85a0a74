//! Batches: what a plan refuses, where it cuts, and that what is cut lies where the whole would.

use sinew_gpu::layout::{
    ALIGNMENT, Array, Attribute, Batch, Buffer, Chunk, DeviceLimits, LayoutError, Plan, Resource,
    Skin, Span, Stage, WORKGROUP, WorkLayout,
};
use sinew_runtime::{Envelope, Model};

const ROTATIONAL: &[u8] = include_bytes!("../../tests/golden/envelope-2-rotational.snw");
const KERNEL: &[u8] = include_bytes!("../../tests/golden/envelope-2-kernel.snw");
const HYBRID: &[u8] = include_bytes!("../../tests/golden/envelope-2-hybrid.snw");

/// A device of large bindings.
const LARGE: DeviceLimits =
    DeviceLimits { storage_binding_bytes: 1 << 32, ..DeviceLimits::DOWNLEVEL };

fn load(bytes: &[u8]) -> (Model<'_>, Envelope<'_>) {
    let model = Model::from_bytes(bytes).expect("a golden loads");
    (model, model.envelope().expect("it holds an envelope"))
}

/// Positions vertex by vertex with gaps, normals of all instances of a vertex side by side, tangents
/// in between.
fn scattered(envelope: &Envelope<'_>, instance_len: usize) -> Batch {
    let attribute = |buffer, offset, stride, instance_stride| {
        Some(Attribute { buffer, offset, stride, instance_stride })
    };
    let skin = Skin {
        vertices: 3..20,
        positions: attribute(Buffer::A, 5, 11, 190),
        normals: attribute(Buffer::B, 1, 7 * instance_len, 7),
        tangents: attribute(Buffer::A, 8, 11, 190),
    };
    Batch {
        instance_len,
        poses: Array { offset: 7, stride: 61 },
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
    use Stage::{Confidence, Correction, Features, Gradients, Joints, Palette, Skin};
    let stages = |bytes, skinned: bool| {
        let (model, envelope) = load(bytes);
        let mut batch = Batch::skinned(&envelope, 2);
        if !skinned {
            batch = Batch { confidences: None, ..Batch::palettes(&envelope, 2) };
        }
        let plan = Plan::new(&model, &envelope, &batch, &LARGE).unwrap();
        plan.stages().collect::<Vec<_>>()
    };
    assert_eq!(stages(ROTATIONAL, true), [Gradients, Palette, Confidence, Skin]);
    assert_eq!(stages(KERNEL, true), [Joints, Features, Correction, Confidence, Skin]);
    assert_eq!(stages(KERNEL, false), [Joints, Features, Correction]);
    let hybrid = [Gradients, Palette, Features, Correction, Confidence, Skin];
    assert_eq!(stages(HYBRID, true), hybrid);
}

#[test]
fn stages_bind_four_storage_buffers_at_most() {
    for stage in Stage::ALL {
        let [params, storage @ ..] = stage.bindings() else { panic!("{stage:?} binds nothing") };
        assert_eq!(params.resource, Resource::Params);
        assert!(storage.len() <= 4, "{stage:?}");
    }
}

/// Each float of each instance lies in its chunk's binding where it would lie in the whole buffer.
#[test]
fn what_is_cut_lies_where_the_whole_would() {
    for bytes in [ROTATIONAL, KERNEL, HYBRID] {
        let (model, envelope) = load(bytes);
        let blob_bytes = model.blob().len() as u64;
        let batch = scattered(&envelope, 100);
        let whole = Plan::new(&model, &envelope, &batch, &LARGE).unwrap();
        assert_eq!(whole.chunks().len(), 1);
        let mut counts = Vec::new();
        for limit in [blob_bytes, blob_bytes + 4096, 1 << 17, 1 << 32] {
            let limits = DeviceLimits { storage_binding_bytes: limit.max(50_000), ..LARGE };
            let plan = Plan::new(&model, &envelope, &batch, &limits).unwrap();
            counts.push(plan.chunks().len());
            let mut next = 0;
            for chunk in plan.chunks() {
                assert_eq!(chunk.instances.start, next);
                next = chunk.instances.end;
                check_chunk(&envelope, &batch, chunk, limits.storage_binding_bytes);
            }
            assert_eq!(next, 100);
            for resource in Resource::ALL.into_iter().filter(|r| *r != Resource::Params) {
                assert_eq!(plan.bytes(resource), whole.bytes(resource), "{resource:?}");
            }
        }
        assert!(counts[0] > 1 && counts.last() == Some(&1), "{counts:?}");
    }
}

fn check_chunk(envelope: &Envelope<'_>, batch: &Batch, chunk: &Chunk, limit: u64) {
    for resource in Resource::ALL {
        let Some(Span { offset, bytes }) = chunk.span(resource) else { continue };
        assert!(offset % ALIGNMENT == 0 && bytes % 4 == 0 && bytes <= limit, "{resource:?}");
    }
    let skin = batch.skin.as_ref().expect("it skins");
    let work = WorkLayout::new(envelope).len;
    let arrays = [
        (Resource::Poses, "poses", batch.poses, 12 * envelope.joint_len()),
        (Resource::Work, "work", Array { offset: 0, stride: work }, work),
        (Resource::Palettes, "palettes", batch.palettes, 12 * envelope.palette_len()),
        (Resource::Confidences, "confidences", batch.confidences.expect("it has them"), 1),
    ];
    for (resource, name, array, len) in arrays {
        let span = chunk.span(resource).expect("it is bound");
        let (offset, stride) =
            (param(chunk, &format!("{name}_offset")), param(chunk, &format!("{name}_stride")));
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
        let Attribute { buffer, offset, stride, instance_stride } =
            attribute.expect("it has all three");
        let (number, resource) = match buffer {
            Buffer::A => (1, Resource::OutA),
            Buffer::B => (2, Resource::OutB),
        };
        let of = |what: &str| param(chunk, &format!("{name}_{what}"));
        assert_eq!(of("buffer"), number);
        let span = chunk.span(resource).expect("it is bound");
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
    let (model, envelope) = load(HYBRID);
    let limits = DeviceLimits { storage_binding_bytes: 300_000, ..LARGE };
    let plan = Plan::new(&model, &envelope, &Batch::skinned(&envelope, 1000), &limits).unwrap();
    assert!(plan.chunks().len() > 2);
    for pair in plan.chunks().windows(2) {
        for resource in [Resource::Poses, Resource::Palettes, Resource::Work, Resource::OutB] {
            let [a, b] = [0, 1].map(|i| pair[i].span(resource).unwrap());
            assert_eq!(a.offset + a.bytes, b.offset, "{resource:?}");
        }
    }
}

#[test]
fn params_hold_the_blocks_of_all_chunks() {
    let (model, envelope) = load(HYBRID);
    let limits = DeviceLimits { storage_binding_bytes: 50_000, ..LARGE };
    let plan = Plan::new(&model, &envelope, &scattered(&envelope, 100), &limits).unwrap();
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
fn dispatches_are_split_past_65535_groups() {
    let (model, envelope) = load(ROTATIONAL);
    for instance_len in [1, 3, 174_763, 400_001] {
        let batch = Batch::skinned(&envelope, instance_len);
        let plan = Plan::new(&model, &envelope, &batch, &LARGE).unwrap();
        let [chunk] = plan.chunks() else { panic!("the bindings are large enough") };
        let threads = (instance_len * envelope.vertex_len()) as u64;
        let least = threads.div_ceil(WORKGROUP.into());
        let [x, y] = plan.groups(Stage::Skin, chunk, instance_len).unwrap().map(u64::from);
        assert!(x <= 65_535 && x * y >= least && x * y < least + y, "{x} {y} {least}");
        assert_eq!(y == 1, least <= 65_535);
        // A workgroup an instance.
        let [x, y] = plan.groups(Stage::Gradients, chunk, instance_len).unwrap().map(u64::from);
        assert!(x * y >= instance_len as u64 && x * y < instance_len as u64 + y);
        assert_eq!(plan.groups(Stage::Joints, chunk, instance_len), None);
    }
}

#[test]
fn fewer_instances_take_fewer_groups() {
    let (model, envelope) = load(KERNEL);
    let limits = DeviceLimits { storage_binding_bytes: 50_000, ..LARGE };
    let plan = Plan::new(&model, &envelope, &Batch::skinned(&envelope, 100), &limits).unwrap();
    let [first, second, ..] = plan.chunks() else { panic!("it is cut") };
    let groups = |chunk, len| plan.groups(Stage::Skin, chunk, len);
    let len = first.instances.len();
    assert_eq!(groups(first, len), groups(first, 100));
    assert_eq!(groups(first, 1), Some([1, 1]));
    assert_eq!(groups(second, len), None);
    assert_eq!(groups(second, len + 1), Some([1, 1]));
}

#[test]
fn what_a_model_or_a_device_does_not_have_is_refused() {
    let (model, envelope) = load(HYBRID);
    let refused = |change: &dyn Fn(&mut Batch)| {
        let mut batch = scattered(&envelope, 4);
        change(&mut batch);
        Plan::new(&model, &envelope, &batch, &LARGE).unwrap_err()
    };
    assert_eq!(refused(&|b| b.instance_len = 0), LayoutError::NoInstances);
    let range = LayoutError::VertexRange { start: 3, end: 25, vertex_len: 24 };
    assert_eq!(refused(&|b| b.skin.as_mut().unwrap().vertices = 3..25), range);
    let stride = |resource, least, found| LayoutError::Stride { resource, least, found };
    let palette = 12 * envelope.palette_len();
    let short = stride(Resource::Palettes, palette, palette - 1);
    assert_eq!(refused(&|b| b.palettes.stride = palette - 1), short);
    for (offset, stride) in [(2, palette), (4, palette + 2)] {
        let odd = refused(&|b| b.palettes = Array { offset, stride });
        assert_eq!(odd, LayoutError::Fours { offset, stride });
    }
    let none = stride(Resource::Confidences, 1, 0);
    assert_eq!(refused(&|b| b.confidences.as_mut().unwrap().stride = 0), none);
    let narrow = |b: &mut Batch| b.skin.as_mut().unwrap().tangents.as_mut().unwrap().stride = 3;
    assert_eq!(refused(&narrow), stride(Resource::OutA, 4, 3));
    let far = |b: &mut Batch| b.poses.offset = usize::MAX;
    assert!(matches!(refused(&far), LayoutError::Binding { resource: Resource::Poses, .. }));

    let on = |limits: DeviceLimits| {
        Plan::new(&model, &envelope, &scattered(&envelope, 4), &limits).unwrap_err()
    };
    let blob = model.blob().len() as u64;
    let small = DeviceLimits { storage_binding_bytes: blob - 1, ..LARGE };
    let limit = LayoutError::Binding { resource: Resource::Blob, limit: blob - 1, found: blob };
    assert_eq!(on(small), limit);
    let devices = [
        DeviceLimits { storage_buffers: 3, ..LARGE },
        DeviceLimits { workgroup_threads: 63, ..LARGE },
        DeviceLimits { groups: 65_534, ..LARGE },
    ];
    for device in devices {
        assert!(matches!(on(device), LayoutError::Device { .. }), "{device:?}");
    }
    let coarse = DeviceLimits { offset_alignment: 512, ..LARGE };
    assert_eq!(on(coarse), LayoutError::OffsetAlignment { limit: 256, found: 512 });
}

#[test]
fn buffers_and_counts_are_checked() {
    let (model, envelope) = load(HYBRID);
    let plan = Plan::new(&model, &envelope, &Batch::palettes(&envelope, 4), &LARGE).unwrap();
    let resource = Resource::Poses;
    let least = plan.bytes(resource);
    assert_eq!(least, 4 * 48 * envelope.joint_len() as u64);
    let given = |offset, bytes| plan.check(resource, Some(Span { offset, bytes }));
    assert_eq!(given(512, least), Ok(()));
    assert_eq!(plan.check(resource, None), Err(LayoutError::Missing { resource }));
    assert_eq!(given(128, least), Err(LayoutError::Misaligned { resource, found: 128 }));
    let short = LayoutError::TooShort { resource, least, found: least - 1 };
    assert_eq!(given(0, least - 1), Err(short));
    // Nothing is skinned: no buffer is needed.
    assert_eq!(plan.check(Resource::OutA, None), Ok(()));
    assert_eq!(plan.check_instances(4), Ok(()));
    assert_eq!(plan.check_instances(0), Err(LayoutError::NoInstances));
    let many = LayoutError::TooManyInstances { expected: 4, found: 5 };
    assert_eq!(plan.check_instances(5), Err(many));
}
