//! Batches of an envelope and a skin: each mistake has its error.

#[path = "../../examples/bandwidth/model.rs"]
mod model;

use super::plans::{KERNEL, LARGE, ROTATIONAL, scattered};
use crate::common::{load, parts};
use sinew_gpu::layout::{
    Array, Batch, DeviceLimits, LayoutError, Plan, Resource, SkinBatch, Span, Stage, WORKGROUP,
};
use sinew_runtime::format::PartKind;
use sinew_runtime::{Envelope, Model, Skin};

#[test]
fn a_batch_beyond_the_model_or_the_device_is_refused() {
    let model = load(KERNEL);
    let (envelope, skin) = parts(&model);
    let refused = |change: &dyn Fn(&mut Batch)| {
        let mut batch = scattered(&envelope, &skin, 4);
        change(&mut batch);
        Plan::new(&model, &envelope, &batch, &LARGE).unwrap_err()
    };
    assert_eq!(refused(&|b| b.instance_len = 0), LayoutError::NoInstances);
    let own = |batch: &mut Batch, change: &dyn Fn(&mut SkinBatch)| {
        change(batch.skin.as_mut().unwrap());
    };
    for (start, end) in [(3, 25), (25, 25), (5, 4)] {
        let range = LayoutError::VertexRange { start, end, vertex_len: 24 };
        assert_eq!(refused(&|b| own(b, &|s| s.vertices = start..end)), range);
    }
    let remap = Some(Array { offset: 0, stride: 0 });
    let (start, end) = (5, 4);
    let range = LayoutError::VertexRange { start, end, vertex_len: 24 };
    assert_eq!(refused(&|b| own(b, &|s| (s.remap, s.vertices) = (remap, start..end))), range);
    let nothing = |s: &mut SkinBatch| (s.positions, s.normals, s.tangents) = (None, None, None);
    assert_eq!(refused(&|b| own(b, &nothing)), LayoutError::NoOutput);
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
    let narrow = |s: &mut SkinBatch| s.tangents.as_mut().unwrap().stride = 3;
    assert_eq!(refused(&|b| own(b, &narrow)), stride(Resource::Out, 4, 3));
    let far = |b: &mut Batch| b.poses.offset = usize::MAX;
    assert!(matches!(refused(&far), LayoutError::Binding { resource: Resource::Poses, .. }));
    let far = |s: &mut SkinBatch| s.rest.normals = Some(Array { offset: usize::MAX, stride: 0 });
    let found = refused(&|b| own(b, &far));
    assert!(matches!(found, LayoutError::Binding { resource: Resource::Host, .. }));

    let on = |limits: DeviceLimits| {
        Plan::new(&model, &envelope, &scattered(&envelope, &skin, 4), &limits).unwrap_err()
    };
    let blob = model.blob().len() as u64;
    let small = DeviceLimits { storage_binding_bytes: blob - 1, ..LARGE };
    let limit = LayoutError::Binding { resource: Resource::Blob, limit: blob - 1, found: blob };
    assert_eq!(on(small), limit);
    let devices = [
        DeviceLimits { storage_buffers: 3, ..LARGE },
        DeviceLimits { workgroup_threads: 63, ..LARGE },
        DeviceLimits { workgroups: 65_534, ..LARGE },
    ];
    for device in devices {
        assert!(matches!(on(device), LayoutError::Device { .. }), "{device:?}");
    }
    let coarse = DeviceLimits { offset_alignment: 512, ..LARGE };
    assert_eq!(on(coarse), LayoutError::OffsetAlignment { limit: 256, found: 512 });
}

#[test]
fn parts_of_another_file_are_refused() {
    let [model, other] = [KERNEL, ROTATIONAL].map(load);
    let ((envelope, skin), (other_envelope, other_skin)) = (parts(&model), parts(&other));
    let planned = |envelope: &Envelope<'_>, skin: &Skin<'_>| {
        let mut batch = Batch::palettes(envelope, 2);
        batch.skin = Some(SkinBatch::new(skin));
        Plan::new(&model, envelope, &batch, &LARGE).map(drop)
    };
    let refused = |part| Err(LayoutError::OtherFile { part });
    assert_eq!(planned(&envelope, &skin), Ok(()));
    assert_eq!(planned(&other_envelope, &skin), refused(PartKind::Envelope));
    assert_eq!(planned(&envelope, &other_skin), refused(PartKind::Skin));
    assert_eq!(
        LayoutError::OtherFile { part: PartKind::Skin }.to_string(),
        "the skin is of another file than the model"
    );
}

#[test]
fn a_skin_that_follows_another_envelope_or_none_is_refused() {
    let mut content = model::file_model(5);
    content.envelopes.push(content.envelopes[0].clone());
    let mut second = content.skins[0].clone();
    (second.name, second.envelope) = ("second".to_owned(), Some(1));
    let mut none = content.skins[0].clone();
    (none.name, none.envelope, none.influences) = ("none".to_owned(), None, Vec::new());
    content.skins.extend([second, none]);
    let model = Model::from_bytes(content.bake().unwrap()).unwrap();
    let envelopes: Vec<_> = model.all::<Envelope>().collect();
    let planned = |envelope: usize, skin: &str| {
        let skin = SkinBatch::new(&model.named::<Skin>(skin).unwrap());
        let batch = Batch { skin: Some(skin), ..Batch::palettes(&envelopes[envelope], 2) };
        Plan::new(&model, &envelopes[envelope], &batch, &DeviceLimits::DOWNLEVEL)
    };
    let refused = |expected, found| LayoutError::OtherEnvelope { expected, found };
    assert_eq!(planned(0, "second").unwrap_err(), refused(0, Some(1)));
    assert_eq!(planned(1, "spiral").unwrap_err(), refused(1, Some(0)));
    assert_eq!(planned(0, "none").unwrap_err(), refused(0, None));

    // Each skin's arrays are found, with equal numbers for equal parts.
    let [first, second] = [planned(0, "spiral").unwrap(), planned(1, "second").unwrap()];
    let words = |plan: &Plan, name: &str| {
        let params = plan.chunks()[0].params().to_vec();
        let at = params.iter().find(|(own, _)| *own == name).unwrap().1 as usize;
        model.blob()[4 * at..][..4 * 15].to_vec()
    };
    for name in ["rest_positions", "rest_normals", "influence_weights", "groups", "corrections"] {
        assert_eq!(words(&first, name), words(&second, name), "{name}");
    }
    assert_ne!(first.params(), second.params());
    assert_eq!(first.bytes(Resource::Out), second.bytes(Resource::Out));
}

#[test]
fn an_instance_of_more_workgroups_than_an_axis_has_is_refused() {
    let model = load(ROTATIONAL);
    let (envelope, skin) = parts(&model);
    let planned = |vertex_len: usize| {
        let mut batch = Batch::palettes(&envelope, 1);
        let mut own = SkinBatch::new(&skin);
        (own.remap, own.vertices) = (Some(Array { offset: 0, stride: 0 }), 0..vertex_len);
        (own.normals, own.tangents) = (None, None);
        batch.skin = Some(own);
        Plan::new(&model, &envelope, &batch, &LARGE)
    };
    let most = 65_535 * WORKGROUP as usize;
    let plan = planned(most).unwrap();
    assert_eq!(plan.workgroups(Stage::Skin, &plan.chunks()[0], 1), Some([65_535, 1]));
    let error = planned(most + 1).unwrap_err();
    let stage = Stage::Skin;
    assert_eq!(error, LayoutError::Workgroups { stage, limit: 65_535, found: 65_536 });
    assert_eq!(error.to_string(), "65536 workgroups for one instance of skin, more than 65535");
}

#[test]
fn buffers_and_counts_are_checked() {
    let model = load(KERNEL);
    let (envelope, _) = parts(&model);
    let plan = Plan::new(&model, &envelope, &Batch::palettes(&envelope, 4), &LARGE).unwrap();
    let resource = Resource::Poses;
    let least = plan.bytes(resource);
    assert_eq!(least, 4 * 48 * envelope.joint_len() as u64);
    // Each resource has its own buffer; resources that are not needed are not requested.
    let with = |own: Option<Span>| {
        plan.check_buffers(|other| match plan.bytes(other) {
            0 => panic!("{other:?} is not needed"),
            _ if other == resource => own.map(|span| (other, span)),
            bytes => Some((other, Span { offset: 256, bytes })),
        })
    };
    let given = |offset, bytes| with(Some(Span { offset, bytes }));
    assert_eq!(given(512, least), Ok(()));
    assert_eq!(with(None), Err(LayoutError::Missing { resource }));
    assert_eq!(given(128, least), Err(LayoutError::Misaligned { resource, found: 128 }));
    let short = LayoutError::TooShort { resource, least, found: least - 1 };
    assert_eq!(given(0, least - 1), Err(short));
    // One buffer for all.
    let all = |at: u64| {
        plan.check_buffers(|other| {
            let offset = if other == Resource::Palettes { at } else { (other as u64) << 20 };
            Some(((), Span { offset, bytes: 1 << 20 }))
        })
    };
    assert_eq!(all((Resource::Palettes as u64) << 20), Ok(()));
    let (first, second) = (resource, Resource::Palettes);
    assert_eq!(all((resource as u64) << 20), Err(LayoutError::Overlap { first, second }));
    assert_eq!(plan.check_instances(4), Ok(()));
    assert_eq!(plan.check_instances(0), Err(LayoutError::NoInstances));
    let many = LayoutError::TooManyInstances { expected: 4, found: 5 };
    assert_eq!(plan.check_instances(5), Err(many));
}
