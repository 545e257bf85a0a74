//! Bytes that change under a loaded model never cause a panic.

use crate::common::{IDENTITY, apart, confident_palette};
use crate::format::ownership::version;
use models::{KernelContent, Pieces, Rest, Rng, SMALL, Shape, TINY, cells, seal};
use sinew_runtime::envelope::{Predictor, ScratchLayout};
use sinew_runtime::format::SectionKind;
use sinew_runtime::kernel::Kernel;
use sinew_runtime::skin::Output;
use sinew_runtime::views::RenderScratch;
use sinew_runtime::{
    Envelope, KernelMap, Matrix3x4, Model, PartLayout, RenderJob, Skin, SkinJob, Views,
    model_space_pose, stages,
};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Bytes that are valid during loading, and others from the second read on.
struct Changing {
    first: Vec<u8>,
    then: Vec<u8>,
    readings: AtomicUsize,
}

impl Changing {
    fn new(first: &[u8], then: Vec<u8>) -> Self {
        Self { first: first.to_vec(), then, readings: AtomicUsize::new(0) }
    }
}

impl AsRef<[u8]> for Changing {
    fn as_ref(&self) -> &[u8] {
        match self.readings.fetch_add(1, Ordering::Relaxed) {
            0 => &self.first,
            _ => &self.then,
        }
    }
}

/// Largest allocation of a test, for any content of a changed file.
const MOST: usize = 1 << 12;

/// Evaluates everything in a model whose bytes change. Returns which indices would have left their
/// arrays.
fn evaluate_changed(first: &[u8], then: Vec<u8>) -> Astray {
    let model = Model::from_bytes(Changing::new(first, then.clone())).unwrap();
    assert_eq!(model.as_bytes(), then, "the second reading gives other bytes");
    let _ = (model.parts().count(), model.blob().len(), model.space(), model.id());
    let _ = model.sections().map(|section| section.bytes.len()).sum::<usize>();
    let _ = format!("{model:?}");
    let mut astray = Astray::default();
    // Layouts come from loading; lists are read from the changed bytes.
    let first_envelope: Option<Envelope<'_>> = model.first::<Envelope>();
    for envelope in first_envelope.into_iter().chain(model.all::<Envelope>()) {
        astray.joined(read_envelope(&envelope));
    }
    let first_skin: Option<Skin<'_>> = model.first::<Skin>();
    let first_kernel: Option<KernelMap<'_>> = model.first::<KernelMap>();
    for map in first_kernel.into_iter().chain(model.all::<KernelMap>()) {
        astray.joined(read_kernel(&map));
    }
    for skin in first_skin.into_iter().chain(model.all::<Skin>()) {
        let _ = model.envelope_of(&skin).map(|envelope| envelope.palette_len());
        astray.joined(read_skin(skin));
    }
    for views in model.all::<Views>() {
        astray.joined(read_views(&views));
    }
    let _ = (model.named::<Envelope>("arm").is_some(), model.named::<Skin>("sleeve").is_some());
    astray
}

/// Kinds of indices that changed bytes sent out of range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Astray {
    influence: bool,
    key: bool,
    parent: bool,
    group: bool,
    input: bool,
    term: bool,
    row: bool,
    vertex: bool,
    texture: bool,
    clip: bool,
}

impl Astray {
    fn joined(&mut self, other: Self) {
        self.influence |= other.influence;
        self.key |= other.key;
        self.parent |= other.parent;
        self.group |= other.group;
        self.input |= other.input;
        self.term |= other.term;
        self.row |= other.row;
        self.vertex |= other.vertex;
        self.texture |= other.texture;
        self.clip |= other.clip;
    }
}

fn read_kernel(map: &KernelMap<'_>) -> Astray {
    let counts = map.counts();
    let [i, o, d, e, n, t, m, _] = counts.words().map(|len| len as usize);
    let _ = (map.name(), map.rule(), map.fit(), format!("{map:?}"));
    let some = |len: usize| (0..len.min(64)).chain([len, usize::MAX]);
    let mut astray = Astray::default();
    for at in some(i.max(o)) {
        let _ = (map.input_name(at), map.output_name(at));
    }
    for at in some(d.max(n)) {
        let _ = (map.feature(at), map.metric_entry(e, at), map.metric_entry(0, at));
        let _ = (map.centre(at, 0), map.coefficient(0, at), map.coefficient(m, at));
    }
    for at in some(t) {
        let is_out = |[earlier, feature]: [u16; 2]| {
            usize::from(feature) >= d || at > 0 && usize::from(earlier) >= at
        };
        astray.term |= at > 0 && map.term(at).is_some_and(is_out);
    }
    astray.row |= map.inputs().count() != i || map.outputs().count() != o;
    let (query_len, result_len) = (map.query_len(), map.result_len());
    let scratch =
        [counts.scratch_len(), counts.jacobian_scratch_len(), counts.variance_scratch_len()];
    let scratch_len = scratch.into_iter().max().unwrap();
    if query_len.max(result_len).max(scratch_len).max(m) <= MOST {
        let query = vec![0.5; query_len];
        let (mut scratch, mut out) = (vec![0.0; scratch_len], vec![0.0; result_len]);
        let _ = map.evaluate(&query, &mut scratch, &mut out);
        let _ = map.jacobian(&query, &mut scratch, &mut vec![0.0; query_len * m]);
        let _ = map.variance(&query, &mut scratch, &mut vec![0.0; m]);
    } else {
        let _ = map.evaluate(&[], &mut [], &mut []);
        let _ = (map.jacobian(&[], &mut [], &mut []), map.variance(&[], &mut [], &mut []));
    }
    astray
}

fn read_views(views: &Views<'_>) -> Astray {
    let counts = views.counts();
    let (k, v, n, l) = (views.point_len(), views.vertex_len(), views.view_len(), views.layer_len());
    let _ = (views.name(), views.fit(), views.size(), views.map_part(0), format!("{views:?}"));
    let some = |len: usize| (0..len.min(64)).chain([len, usize::MAX]);
    let mut astray = Astray::default();
    for layer in some(l) {
        let _ = (views.layer_name(layer), views.view_texture(0, layer));
        // A chain of clips may become a circle after a change.
        astray.clip |= views.clips(layer).any(|clip| clip == layer);
    }
    for view in some(n) {
        let _ = (views.view_name(view), views.ratio(view), views.offset(view, k));
        let _ = (views.texel(view, v), views.reference(view, k), views.is_visible(view, k));
        let texture = views.view_texture(view, 0);
        astray.texture |= texture.is_some_and(|texture| views.texture(texture).is_none());
    }
    for element in some(views.element_len()) {
        let vertices = views.element(element);
        let is_out = |vertex: &usize| views.vertex(*vertex).is_none();
        astray.vertex |= vertices.is_some_and(|element| element.vertices().iter().any(is_out));
        let _ = views.neighbours(element);
    }
    let points = vec![[1.0; 3]; k.min(MOST)];
    let (visibility, scores) = (vec![1.0; k.min(MOST)], vec![1.0; n.min(MOST)]);
    let layers = vec![[1.0, 0.0]; l.min(MOST)];
    let (points, visibility, scores, layers) = (&*points, &*visibility, &*scores, &*layers);
    let job = RenderJob { views: *views, points, visibility, scores, layers, width: 16 };
    let scratch = RenderScratch {
        vertices: &mut vec![[0.0; 3]; v.min(MOST)],
        order: &mut vec![0; views.order_len().min(MOST)],
        depths: &mut [0.0; 16 * 12],
        group: &mut [[0; 4]; 16 * 12],
        clips: &mut [0; 16 * 12],
    };
    let is_small = [counts.point_len, counts.vertex_len, counts.view_len, counts.layer_len]
        .into_iter()
        .all(|len| len as usize <= MOST);
    let drawn = job.run(scratch, &mut [[0; 4]; 16 * 12]);
    assert!(drawn.is_ok() || !is_small || views.order_len() > MOST);
    astray
}

fn read_envelope(envelope: &Envelope<'_>) -> Astray {
    let (j, p, len) = (envelope.joint_len(), envelope.proxy_len(), envelope.palette_len());
    let _ = (envelope.name(), envelope.certificate(), envelope.root(), format!("{envelope:?}"));
    let some = |len: usize| (0..len.min(64)).chain([len, usize::MAX]);
    let mut astray = Astray::default();
    for joint in some(j) {
        let _ = (envelope.joint_name(joint), envelope.inverse_bind(joint));
        let _ = (envelope.origin(joint), envelope.pose_range(joint), envelope.pose_gap(joint));
        let _ = envelope.stretch_range(joint);
        astray.parent |= envelope.parent(joint).is_some_and(|parent| parent >= j);
    }
    astray.parent |= envelope.evaluation_order().any(|joint| joint >= j);
    for proxy in some(p) {
        let residual = |key: sinew_runtime::envelope::Key| key.residual.map_or(0, |(c, _)| c);
        let key = envelope.key(proxy);
        astray.key |= key.is_some_and(|key| key.joint >= j || residual(key) >= j);
        let _ = (envelope.c1(4 * p.min(64), proxy), envelope.c2(proxy, j));
    }
    for curve in some(envelope.curve_len()) {
        let _ = (envelope.curve_name(curve), envelope.curve_range(curve));
    }
    let feature_len = envelope.counts().feature_len();
    for group in envelope.groups().take(64) {
        astray.group |= j > 0 && group.joint >= j || group.proxies.end > p;
        let (d, n) = (group.input_len(), group.centre_len());
        for i in some(d) {
            astray.input |= group.input(i).is_some_and(|(feature, _)| feature >= feature_len);
            let _ = (group.centre(n, i), group.centre(0, i), group.coefficient(0, n + i.min(d)));
        }
        let _ = (group.rest(n), group.output(0, 0), group.rank());
    }
    let _ = envelope.group(envelope.group_len());
    let _ = ScratchLayout::at_once(envelope);
    let scratch_len = envelope.scratch_len();
    if j.max(len).max(scratch_len).max(p).max(feature_len) <= MOST {
        evaluate_envelope(envelope);
    } else {
        let _ = envelope.palette(&[], &[], &mut [], &mut []);
        let _ = envelope.palettes(&[], &[], &mut [], &mut [], &mut [0.0]);
    }
    astray
}

fn evaluate_envelope(envelope: &Envelope<'_>) {
    let (j, p, len) = (envelope.joint_len(), envelope.proxy_len(), envelope.palette_len());
    let local = vec![Rng(1).local(0.2); j];
    let mut pose = vec![IDENTITY; j];
    let _ = model_space_pose(envelope, &local, &mut pose);
    pose.iter_mut().flatten().flatten().for_each(|x| *x = if x.is_finite() { *x } else { 0.0 });
    let mut out = vec![IDENTITY; 2 * len];
    let mut scratch = vec![0.0; envelope.scratch_len().max(envelope.correction_len())];
    let (c, split) = (envelope.curve_len(), if envelope.stretches() { j } else { 0 });
    let (curves, two) = (vec![0.5; c], vec![0.5; 2 * c]);
    let _ = envelope.palette(&pose, &curves, &mut scratch, &mut out[..len]);
    let _ = envelope.rotational_palette(&pose, &mut scratch, &mut out[..len]);
    let poses = [pose.as_slice(), &pose].concat();
    let _ = envelope.palettes(&poses, &two, &mut scratch, &mut out, &mut [0.0; 2]);
    let _ = envelope.joint_confidences(&pose, &curves, &mut scratch, &mut vec![0.0; j]);
    let _ = (envelope.check_pose(&pose, &curves), envelope.bind_curves(["blink"], &mut [0]));
    let (mut turns, mut strains) = (vec![[[0.0; 3]; 3]; split], vec![[0.0; 6]; split]);
    let _ = stages::polar(envelope, &pose, &mut turns, &mut strains);
    let (mut q, mut theta) = (vec![[0.0; 3]; 4 * j], vec![[0.0; 3]; j]);
    let (mut d, mut features) = (vec![[0.0; 3]; 3 * p], vec![0.0; envelope.counts().feature_len()]);
    let of_pose = (&turns[..], &strains[..]);
    let _ = stages::gradients(envelope, &pose, of_pose, &mut q, &mut theta, &mut d);
    let root = pose.first().copied().unwrap_or(IDENTITY);
    let _ = stages::palette(envelope, &root, &q, &d, &mut out[..len]);
    let _ = stages::joints(envelope, &pose, &mut out[..len]);
    let _ = stages::features(envelope, &pose, &curves, &turns, &mut features);
    let _ = stages::correction(envelope, &pose, &features, &mut scratch, &mut out[..len]);
    let _ = stages::confidence(envelope, &pose, &theta, &strains);
}

fn read_skin(skin: Skin<'_>) -> Astray {
    let (v, len) = (skin.vertex_len(), skin.palette_len());
    let _ = (skin.name(), skin.envelope_part(), format!("{skin:?}"));
    let some = |len: usize| (0..len.min(64)).chain([len, usize::MAX]);
    let mut astray = Astray::default();
    for vertex in some(v) {
        let _ = (skin.rest_position(vertex), skin.rest_normal(vertex), skin.rest_tangent(vertex));
        astray.influence |= skin.influences(vertex).take(MOST).any(|(index, _)| index >= len);
    }
    some(len).for_each(|index| assert!(index < len || skin.rest_box(index).is_none()));
    let _ = skin.ranges().take(MOST).count();
    if v.max(len) > MOST {
        let _ = skin.skin_positions(&[], &mut []);
        return astray;
    }
    let palette = vec![IDENTITY; len];
    let _ = (skin.bounds(&palette, 0.0), skin.bounds(&palette, 0.5));
    let _ = skin.skin_positions(&palette, &mut vec![[0.0; 3]; v]);
    let (mut a, mut b) = (vec![0.0; 6 * v], vec![0.0; 4 * v]);
    let a = cells(&mut a);
    let whole = SkinJob::new(skin, &palette)
        .positions(Output::shared(a, 6))
        .normals(Output::shared(a.get(3..).unwrap_or_default(), 6))
        .tangents(Some(Output::new(&mut b, 4)).filter(|_| skin.has_tangents()));
    let _ = whole.run();
    let (rest, remap) = (vec![[0.5; 3]; v], vec![v.saturating_sub(1) as u32; v]);
    let rest = Rest { positions: Some(&rest), normals: Some(&rest), tangents: None };
    let _ = rest.of(whole).remap(&remap).run();
    astray
}

/// A sample of each predictor, one of each whose joints stretch, one without joints, one of several
/// small parts, one of kernels, and one of key views.
fn sound() -> Vec<Vec<u8>> {
    let samples = Predictor::ALL.map(|predictor| Pieces::sample(predictor, TINY));
    let stretching = Shape { stretches: true, curves: 2, ..TINY };
    let stretching = Predictor::ALL.map(|predictor| Pieces::sample(predictor, stretching));
    let jointless = Pieces::sample(Predictor::Kernel, Shape { joints: 0, curves: 2, ..TINY });
    let several = samples.each_ref().map(Pieces::clone).into_iter();
    let several = several.reduce(|mut all, next| {
        all.append(next);
        all
    });
    let mut several = several.unwrap();
    several.append(Pieces::loose(TINY));
    let kernels = [KernelContent::servo(), KernelContent::every(Kernel::Cubic)];
    let [_, views] = Pieces::viewed();
    samples
        .iter()
        .chain(&stretching)
        .chain([&jointless, &several, &Pieces::kernels(&kernels), &views])
        .map(Pieces::bytes)
        .collect()
}

#[test]
fn bytes_that_change_after_loading_never_make_a_panic() {
    let mut seen = Astray::default();
    for first in sound() {
        // Shorter, and longer.
        for len in (0..first.len()).step_by(apart(1_999)) {
            seen.joined(evaluate_changed(&first, first[..len].to_vec()));
        }
        seen.joined(evaluate_changed(&first, [first.as_slice(), &[0xff; 99]].concat()));
        // Every byte, with one bit or all bits changed.
        for at in (0..first.len()).step_by(apart(1_999)) {
            for flip in [1, 0x10, 0x80, 0xff] {
                let mut then = first.clone();
                then[at] ^= flip;
                seen.joined(evaluate_changed(&first, then));
            }
        }
        // Only ones, zeros, or noise.
        let mut rng = Rng(41);
        for value in [0, 0x7f, 0xff] {
            seen.joined(evaluate_changed(&first, vec![value; first.len()]));
        }
        for _ in (0..200).step_by(apart(100)) {
            let noise = (0..first.len()).map(|_| rng.next_u64() as u8).collect::<Vec<_>>();
            seen.joined(evaluate_changed(&first, noise));
        }
        // Another valid file.
        for then in sound() {
            seen.joined(evaluate_changed(&first, then));
        }
    }
    // Control: the damage sent every kind of index out of range, so an unchecked index would have
    // panicked.
    let every = Astray {
        influence: true,
        key: true,
        parent: true,
        group: true,
        input: true,
        term: true,
        row: true,
        vertex: true,
        texture: true,
        clip: true,
    };
    assert!(cfg!(miri) || seen == every, "{seen:?}");
}

#[test]
fn views_from_a_layout_never_panic_on_changed_bytes() {
    let first = version(0);
    let model = Model::from_bytes(first.as_slice()).unwrap();
    let layouts: [PartLayout; 2] =
        [model.first::<Envelope>().unwrap().layout(), model.first::<Skin>().unwrap().layout()];
    let mut opened = 0;
    for at in (0..first.len()).step_by(apart(499)) {
        for flip in [1, 0x80, 0xff] {
            let mut then = first.clone();
            then[at] ^= flip;
            // The bytes state the old file's checksum, and open.
            if let (Some(envelope), Some(skin)) =
                (layouts[0].open::<Envelope>(&then), layouts[1].open::<Skin>(&then))
            {
                opened += 1;
                read_envelope(&envelope);
                read_skin(skin);
            }
            // With their own checksum they do not open.
            seal(&mut then);
            let other = layouts[0].open::<Envelope>(&then).is_none()
                && layouts[1].open::<Skin>(&then).is_none();
            assert!(other || then == first, "{at}");
        }
    }
    assert!(opened > first.len() / apart(499), "{opened}");
}

#[test]
fn without_index_checks_changed_bytes_would_panic() {
    fn unchecked(skin: Skin<'_>, palette: &[Matrix3x4]) -> f32 {
        let vertices = 0..skin.vertex_len();
        let influences = vertices.flat_map(|vertex| skin.influences(vertex));
        influences.map(|(index, weight)| weight * palette[index][0][0]).sum()
    }
    let first = version(0);
    let mut then = first.clone();
    let span = Model::from_bytes(first.as_slice()).unwrap().sections().find_map(|section| {
        let start = section.bytes.as_ptr().addr() - first.as_ptr().addr();
        let is_it = section.row.kind == SectionKind::InfluenceIndices.number();
        is_it.then_some(start..start + section.bytes.len())
    });
    then[span.unwrap()].fill(0xff);
    let evaluate = |bytes: Vec<u8>| {
        let model = Model::from_bytes(Changing::new(&first, bytes)).unwrap();
        let (skin, envelope) = (model.first::<Skin>().unwrap(), model.first::<Envelope>().unwrap());
        let palette = vec![IDENTITY; envelope.palette_len()];
        assert!(skin.skin_positions(&palette, &mut [[0.0; 3]; SMALL.vertices]).is_ok());
        let pose = vec![IDENTITY; SMALL.joints];
        assert_eq!(confident_palette(&envelope, &pose).0.len(), palette.len());
        catch_unwind(AssertUnwindSafe(|| unchecked(skin, &palette)))
    };
    assert!(evaluate(first.clone()).is_ok());
    assert!(evaluate(then).is_err());
}
