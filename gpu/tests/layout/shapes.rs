//! Batches of shapes: refusals, workgroups, and the places of arrays in chunks.

use crate::common::load;
use models::Pieces;
use sinew_gpu::layout::{
    Array, Attribute, DeviceLimits, LayoutError, Plan, Resource, ShapesBatch, Span, Stage,
};
use sinew_runtime::Skin;
use sinew_runtime::format::{Element, PartKind, SectionKind};

const LIMITS: DeviceLimits = DeviceLimits::DOWNLEVEL;

/// Two files of 150 vertices and 8 shapes in whole numbers: with tangents, and without.
fn files() -> [Vec<u8>; 2] {
    let [_, without, with, _] = Pieces::shaped();
    [with.bytes(), without.bytes()]
}

#[test]
fn a_workgroup_is_a_block() {
    let [bytes, _] = files();
    let model = load(&bytes);
    let skin = model.first::<Skin>().unwrap();
    for (vertices, blocks) in [(0..150, 3), (0..64, 1), (63..65, 2), (64..128, 1), (149..150, 1)] {
        let batch = ShapesBatch { vertices: vertices.clone(), ..ShapesBatch::new(&skin, 5) };
        let plan = Plan::of_shapes(&model, &skin, &batch, &LIMITS).unwrap();
        assert!(plan.stages().eq([Stage::Shapes]));
        let chunk = &plan.chunks()[0];
        assert_eq!(plan.workgroups(Stage::Shapes, chunk, 5), Some([blocks, 5]), "{vertices:?}");
    }
    let batch = ShapesBatch { vertices: 9..9, ..ShapesBatch::new(&skin, 5) };
    let plan = Plan::of_shapes(&model, &skin, &batch, &LIMITS).unwrap();
    assert_eq!((plan.stages().len(), plan.bytes(Resource::Out)), (0, 0));
}

#[test]
fn counts_and_sections_are_those_of_the_skin() {
    let [bytes, _] = files();
    let model = load(&bytes);
    let skin = model.first::<Skin>().unwrap();
    let batch = ShapesBatch { vertices: 5..70, tangents: None, ..ShapesBatch::new(&skin, 2) };
    let plan = Plan::of_shapes(&model, &skin, &batch, &LIMITS).unwrap();
    let params = plan.chunks()[0].params();
    let param = |name: &str| params.iter().find(|(own, _)| *own == name).unwrap().1;
    let i8 = u32::from(Element::I8.number());
    assert_eq!(["vertex_first", "vertex_len", "element"].map(param), [5, 65, i8]);
    assert_eq!(param("tangents_offset"), u32::MAX);
    for kind in [SectionKind::RestTangents, SectionKind::ShapeBlocks, SectionKind::ShapeSlopes] {
        let mut sections = model.sections().map(|section| section.row);
        let own = (skin.part() as u16, kind.number());
        let row = sections.find(|row| (row.part, row.kind) == own).unwrap();
        assert_eq!(4 * param(kind.name()), row.offset, "{kind:?}");
    }
}

/// In a chunk's binding, each float of each face is at its place in the whole buffer.
#[test]
fn chunks_keep_the_places_of_the_whole_batch() {
    let [bytes, _] = files();
    let model = load(&bytes);
    let skin = model.first::<Skin>().unwrap();
    let weights = Array { offset: 3, stride: skin.shape_len() + 1 };
    let batch = ShapesBatch { weights, ..ShapesBatch::new(&skin, 300) };
    let storage_binding_bytes = model.blob().len().next_multiple_of(4) as u64;
    let limits = DeviceLimits { storage_binding_bytes, ..LIMITS };
    let plan = Plan::of_shapes(&model, &skin, &batch, &limits).unwrap();
    assert!(plan.chunks().len() > 2);
    let normals = batch.normals.unwrap();
    let arrays = [
        (Resource::Weights, ["weights_offset", "weights_stride"], weights, skin.shape_len()),
        (
            Resource::Out,
            ["normals_offset", "normals_instance_stride"],
            Array { offset: normals.offset, stride: normals.instance_stride },
            3 * skin.vertex_len(),
        ),
    ];
    for chunk in plan.chunks() {
        for (resource, names, array, len) in arrays {
            let Span { offset, bytes } = chunk.span(resource).unwrap();
            assert!(bytes <= storage_binding_bytes, "{resource:?}");
            let [first, stride] = names.map(|name| {
                let found = chunk.params().iter().find(|(own, _)| *own == name);
                u64::from(found.unwrap().1)
            });
            for (local, instance) in chunk.instances.clone().enumerate() {
                let bound = offset / 4 + first + local as u64 * stride;
                assert_eq!(bound, (array.offset + instance * array.stride) as u64, "{names:?}");
                assert!(4 * (bound + len as u64) <= offset + bytes, "{names:?}");
            }
        }
    }
}

#[test]
fn a_batch_that_does_not_fit_the_skin_is_refused() {
    let [bytes, other] = files();
    let (model, other) = (load(&bytes), load(&other));
    let skin = model.first::<Skin>().unwrap();
    let planned = |skin: &Skin<'_>, edit: &dyn Fn(&mut ShapesBatch)| {
        let mut batch = ShapesBatch::new(skin, 4);
        edit(&mut batch);
        Plan::of_shapes(&model, skin, &batch, &LIMITS).map(drop)
    };
    let refused = |edit: &dyn Fn(&mut ShapesBatch)| planned(&skin, edit).unwrap_err();
    assert_eq!(planned(&skin, &|_| {}), Ok(()));
    let foreign = planned(&other.first::<Skin>().unwrap(), &|_| {});
    assert_eq!(foreign, Err(LayoutError::OtherFile { part: PartKind::Skin }));
    assert_eq!(refused(&|b| b.instance_len = 0), LayoutError::NoInstances);
    let nothing = refused(&|b| (b.positions, b.normals, b.tangents) = (None, None, None));
    assert_eq!(nothing, LayoutError::NoOutput);
    for (start, end) in [(0, 151), (9, 8)] {
        let range = LayoutError::VertexRange { start, end, vertex_len: 150 };
        assert_eq!(refused(&|b| b.vertices = start..end), range);
    }
    let short = LayoutError::Stride { resource: Resource::Out, least: 3, found: 2 };
    assert_eq!(refused(&|b| b.normals.as_mut().unwrap().stride = 2), short);
    let any = Some(Attribute { offset: 0, stride: 4, instance_stride: 600 });
    let plain = other.first::<Skin>().unwrap();
    let batch = ShapesBatch { tangents: any, ..ShapesBatch::new(&plain, 4) };
    let tangents = Plan::of_shapes(&other, &plain, &batch, &LIMITS).map(drop);
    assert_eq!(tangents, Err(LayoutError::NoTangents));
    assert_eq!(planned(&skin, &|b| b.weights.stride = 0), Ok(()));
    let far = refused(&|b| b.weights.offset = usize::MAX);
    assert!(matches!(far, LayoutError::Binding { resource: Resource::Weights, .. }));
}
