//! Loading and evaluating allocate nothing.
use crate::allocator::allocated;
use crate::common;
use crate::common::random_pose;
use models::{
    JOINTLESS, KernelContent, Pieces, Rng, SMALL, STRETCHING, Shape, ViewsContent, cells,
};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::kernel::Kernel;
use sinew_runtime::skin::{CacheLine, Output};
use sinew_runtime::views::{Layer, RenderScratch};
use sinew_runtime::{
    Envelope, Frame, FrameJob, KernelMap, LocalTransform, Model, Pin, PinJob, Pins, Prior,
    RenderJob, ShapesJob, Skin, SkinJob, Views, model_space_pose,
};

/// Returns the number of allocations that `work` makes.
fn allocations(work: impl FnOnce()) -> usize {
    let [before, _] = allocated();
    work();
    allocated()[0] - before
}

#[test]
fn nothing_is_allocated() {
    for predictor in Predictor::ALL {
        [SMALL, STRETCHING].into_iter().for_each(|shape| evaluate(predictor, shape));
    }
    evaluate(Predictor::Kernel, JOINTLESS);
}

fn evaluate(predictor: Predictor, shape: Shape) {
    let bytes = Pieces::sample(predictor, shape).bytes();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
    let v = skin.vertex_len();
    let mut pose = random_pose(&envelope, &mut Rng(1), 0.5);
    let local = vec![
        LocalTransform { rotation: [0.0, 0.0, 0.6, 0.8], translation: [0.0; 3] };
        envelope.joint_len()
    ];
    let (curves, two) = (vec![0.5; envelope.curve_len()], vec![0.5; 2 * envelope.curve_len()]);
    let poses = [pose.as_slice(), &pose].concat();
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut palette = vec![common::IDENTITY; envelope.palette_len()];
    let (mut palettes, mut confidences) = ([palette.as_slice(), &palette].concat(), [0.0; 2]);
    let (mut a, mut b) = (vec![0.0; 6 * v], vec![0.0; 4 * v]);
    let (positions, remap) = (vec![[0.5; 3]; v], vec![1; v]);
    let mut skin_scratch = vec![CacheLine::default(); skin.scratch_len()];
    let count = allocations(|| {
        let model = Model::from_bytes(bytes.as_slice()).unwrap();
        let envelope = model.named::<Envelope>("arm").unwrap();
        let skin = model.named::<Skin>("sleeve").unwrap();
        assert!(model.envelope_of(&skin).is_some());
        let (envelope, skin) =
            (envelope.layout().open::<Envelope>(&bytes), skin.layout().open::<Skin>(&bytes));
        let (envelope, skin) = (envelope.unwrap(), skin.unwrap());
        assert_eq!((model.all::<Envelope>().count(), model.all::<Skin>().count()), (1, 1));
        model_space_pose(&envelope, &local, &mut pose).unwrap();
        envelope.check_pose(&pose, &curves).ok();
        let confidence = envelope.palette(&pose, &curves, &mut scratch, &mut palette).unwrap();
        assert!(confidence.is_finite());
        envelope.palettes(&poses, &two, &mut scratch, &mut palettes, &mut confidences).unwrap();
        assert_eq!(envelope.group(0).is_some(), predictor.corrects());
        skin.bounds(&palette, 0.25).unwrap();
        assert_eq!(skin.ranges().count(), 2);
        let a = cells(&mut a);
        let whole = SkinJob::new(skin, &palette)
            .positions(Output::shared(a, 6))
            .normals(Output::shared(&a[3..], 6))
            .tangents(Output::new(&mut b, 4));
        whole.run().unwrap();
        let positions_only = whole.clone().normals(None).tangents(None);
        positions_only.scratch(&mut skin_scratch).run().unwrap();
        whole.remap(&remap).rest_positions(&positions).run().unwrap();
        assert!(Model::from_bytes(&bytes[1..]).is_err());
    });
    assert_eq!(count, 0);
}

#[test]
fn kernels_allocate_nothing() {
    let bytes = Pieces::kernels(&[KernelContent::every(Kernel::Matern52)]).bytes();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let map = model.first::<KernelMap>().unwrap();
    let (counts, query) = (map.counts(), vec![0.5; map.query_len()]);
    let lens = [counts.scratch_len(), counts.jacobian_scratch_len(), counts.variance_scratch_len()];
    let mut scratch = vec![0.0; lens.into_iter().max().unwrap()];
    let (mut out, mut jacobian, mut variances) = (vec![0.0; 10], vec![0.0; 24 * 9], vec![0.0; 9]);
    let count = allocations(|| {
        let model = Model::from_bytes(bytes.as_slice()).unwrap();
        let map = model.named::<KernelMap>("every").unwrap();
        let map = map.layout().open::<KernelMap>(&bytes).unwrap();
        assert!(map.evaluate(&query, &mut scratch, &mut out).unwrap().is_finite());
        map.jacobian(&query, &mut scratch, &mut jacobian).unwrap();
        map.variance(&query, &mut scratch, &mut variances).unwrap();
        assert!(map.evaluate(&query[1..], &mut scratch, &mut out).is_err());
    });
    assert_eq!(count, 0);
}

#[test]
fn pins_allocate_nothing() {
    let bytes = Pieces::face().bytes();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let (prior, skin) = (model.first::<Prior>().unwrap(), model.first::<Skin>().unwrap());
    let mut scratch = vec![0.0; prior.counts().pin_scratch_len(12)];
    let mut weights = vec![0.5; 8];
    let count = allocations(|| {
        let model = Model::from_bytes(bytes.as_slice()).unwrap();
        let prior = model.named::<Prior>("prior").unwrap().layout();
        let prior = prior.open::<Prior>(&bytes).unwrap();
        let skin = model.skin_of(&prior).unwrap();
        let mut pins = Pins::<4>::new();
        for vertex in 0..4 {
            pins.add(Pin::new(vertex, [0.25 * vertex as f32; 3])).unwrap();
        }
        assert!(pins.add(Pin::new(5, [0.0; 3])).is_err());
        let job = PinJob { cancels: true, symmetry: 1.0, ..PinJob::new(prior, skin, pins.list()) };
        let edit = job.run(&mut scratch, &mut weights).unwrap();
        assert!(edit.is_least && edit.round_len > 0);
        assert!(job.run(&mut scratch[1..], &mut weights).is_err());
        assert!(skin.place(3, &[], &weights).is_some());
    });
    assert_eq!(count, 0);
    assert_eq!(skin.shape_len(), weights.len());
}

#[test]
fn shapes_allocate_nothing() {
    let [pieces, ..] = Pieces::shaped();
    let bytes = pieces.bytes();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    let skin = model.first::<Skin>().unwrap();
    let (weights, palette) =
        (vec![0.5; skin.shape_len()], vec![common::IDENTITY; skin.palette_len()]);
    let mut out = vec![0.0; 10 * skin.vertex_len()];
    let count = allocations(|| {
        let model = Model::from_bytes(bytes.as_slice()).unwrap();
        let skin = model.first::<Skin>().unwrap();
        assert_eq!(skin.shape_name(2), Some("shape 2"));
        assert!(skin.deltas_of(7).count() > 0);
        skin.shaped_bounds(&palette, &weights).unwrap();
        let out = cells(&mut out);
        ShapesJob::new(skin, &weights)
            .positions(Output::shared(out, 10))
            .normals(Output::shared(&out[3..], 10))
            .tangents(Output::shared(&out[6..], 10))
            .run()
            .unwrap();
    });
    assert_eq!(count, 0);
}

#[test]
fn views_allocate_nothing() {
    // The second layer has depth, and is clipped.
    let mut content = ViewsContent::sample(vec![0], true);
    content.layers[1].flags = Layer::DEPTH;
    let mut pieces = Pieces::kernels(&[KernelContent::map("walk", 51)]);
    pieces.add_views(&content);
    let bytes = pieces.bytes();
    let mut scratch = vec![0.0; 256];
    let (mut points, mut visibility, mut scores) = ([[0.0; 3]; 9], [0.0; 9], [0.0; 3]);
    let (mut layers, mut vertices) = ([[0.0; 2]; 2], [[0.0; 3]; 10]);
    let (mut pixels, mut depths) = (vec![[0; 4]; 48 * 40], vec![f32::MAX; 48 * 40]);
    let (mut group, mut clips) = (vec![[0; 4]; 48 * 40], vec![0; 48 * 40]);
    let count = allocations(|| {
        let model = Model::from_bytes(bytes.as_slice()).unwrap();
        let views = model.named::<Views>("object").unwrap().layout();
        let views = views.open::<Views>(&bytes).unwrap();
        let map = model.map_of(&views, 0).unwrap();
        let (points, visibility, scores) = (&mut points, &mut visibility, &mut scores);
        let mut out = Frame { points, visibility, scores, layers: &mut layers };
        FrameJob { views, map, parameters: &[0.25, 0.5] }.run(&mut scratch, &mut out).unwrap();
        let layers = &layers;
        let job = RenderJob { views, points, visibility, scores, layers, width: 48 };
        let (vertices, order) = (&mut vertices, &mut [0; 9]);
        let scratch = RenderScratch {
            vertices,
            order,
            depths: &mut depths,
            group: &mut group,
            clips: &mut clips,
        };
        assert!(job.run(scratch, &mut pixels).unwrap().element_len > 0);
        let scratch =
            RenderScratch { vertices, order, depths: &mut depths, group: &mut [], clips: &mut [] };
        assert!(job.run(scratch, &mut pixels).is_err());
    });
    assert_eq!(count, 0);
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![1u8]))), 1);
}
