//! Calls the whole runtime with arguments unknown to the compiler, and links only if no call can
//! panic.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use core::hint::black_box;
use firmware::say;
use sinew_runtime::envelope::GroupKernel;
use sinew_runtime::envelope::{Certificate, EnvelopeCounts, GroupRow, ScratchLayout, Trs};
use sinew_runtime::filter::{FilterCounts, FilterFit, Samples};
use sinew_runtime::format::{
    Axis, Element, FileId, PartKind, PartRow, SectionKind, SectionRow, checksum,
};
use sinew_runtime::kernel::{
    EulerOrder, InputKind, InputRow, Kernel, KernelCounts, KernelFit, KernelRule, OutputKind,
    OutputRow,
};
use sinew_runtime::prior::{Anchor, PriorCounts, Temporal};
use sinew_runtime::skin::{NormalErrors, Output, ShapeErrors, SkinCounts};
use sinew_runtime::{
    CallError, Envelope, Filter, KernelMap, Limits, LocalTransform, Matrix3x4, Model, PartLayout,
    Pin, PinJob, Pins, Prior, ShapesJob, Skin, SkinJob, gather_pose, model_space_pose, stages,
};

firmware::image!(run);

fn run() -> bool {
    let bytes = some::<u8>(&[]);
    say!("{}", checksum(bytes));
    let model = match Model::from_bytes_with(bytes, &black_box(Limits::DEFAULT)) {
        Ok(model) => model,
        Err(error) => {
            say!("{error}");
            return true;
        }
    };
    tables(&model);
    let name = core::str::from_utf8(bytes).unwrap_or_default();
    let first = [model.first::<Envelope>(), model.named::<Envelope>(name)].into_iter().flatten();
    for envelope in first.chain(model.all::<Envelope>()) {
        of_envelope(envelope);
        let kept: PartLayout = envelope.layout();
        if let Some(envelope) = kept.open::<Envelope>(some(&[])) {
            of_envelope(envelope);
        }
    }
    for skin in [model.first::<Skin>(), model.named::<Skin>(name)]
        .into_iter()
        .flatten()
        .chain(model.all::<Skin>())
    {
        black_box(model.envelope_of(&skin).is_some());
        of_skin(skin);
        let kept: PartLayout = skin.layout();
        if let Some(skin) = kept.open::<Skin>(some(&[])) {
            of_skin(skin);
        }
    }
    let first = [model.first::<KernelMap>(), model.named::<KernelMap>(name)].into_iter().flatten();
    for kernel in first.chain(model.all::<KernelMap>()) {
        of_kernel(kernel);
        let kept: PartLayout = kernel.layout();
        if let Some(kernel) = kept.open::<KernelMap>(some(&[])) {
            of_kernel(kernel);
        }
    }
    let first = [model.first::<Prior>(), model.named::<Prior>(name)].into_iter().flatten();
    for prior in first.chain(model.all::<Prior>()) {
        if let Some(skin) = model.skin_of(&prior) {
            tell(pinned(prior, skin));
        }
        let kept: PartLayout = prior.layout();
        black_box(kept.open::<Prior>(some(&[])).is_some());
    }
    let first = [model.first::<Filter>(), model.named::<Filter>(name)].into_iter().flatten();
    for filter in first.chain(model.all::<Filter>()) {
        of_filter(filter);
        let kept: PartLayout = filter.layout();
        if let Some(filter) = kept.open::<Filter>(some(&[])) {
            of_filter(filter);
        }
    }
    black_box(model.into_bytes());
    true
}

#[inline(never)]
fn of_filter(filter: Filter<'_>) {
    black_box((filter.name(), filter.part(), filter.file(), filter.counts(), filter.fit()));
    black_box((filter.tap(index(), index(), index()), filter.variance(index(), index())));
    black_box(filter.window(index(), index()));
    let (signal_len, sample_len, lane_len) = (index(), index(), index());
    let shape = Samples { signal_len, sample_len, lane_len };
    tell(filter.apply(shape, some(&[]), some_mut(&mut [])));
}

#[inline(never)]
fn of_envelope(envelope: Envelope<'_>) {
    numbers(envelope);
    arrays(envelope);
    groups(envelope);
    for outcome in [evaluate(envelope), base(envelope), correction(envelope)] {
        tell(outcome);
    }
}

#[inline(never)]
fn of_skin(skin: Skin<'_>) {
    mesh(skin);
    tell(skinned(skin));
    tell(shaped(skin));
}

#[inline(never)]
fn of_kernel(kernel: KernelMap<'_>) {
    let k = kernel;
    black_box((k.name(), k.part(), k.file(), k.rule(), k.fit(), k.has_variance()));
    black_box((k.input_name(index()), k.output_name(index()), k.query_len(), k.result_len()));
    black_box((k.feature(index()), k.metric_entry(index(), index()), k.centre(index(), index())));
    black_box((k.term(index()), k.coefficient(index(), index())));
    for (input, output) in k.inputs().zip(k.outputs()) {
        black_box((input, input.to_bytes(), output, output.to_bytes()));
    }
    let counts = k.counts();
    black_box([counts.scratch_len(), counts.jacobian_scratch_len(), counts.variance_scratch_len()]);
    let (query, scratch) = (some::<f32>(&[]), some_mut::<f32>(&mut []));
    tell(k.evaluate(query, scratch, some_mut(&mut [])).map(|confidence| {
        black_box(confidence);
    }));
    tell(k.jacobian(query, scratch, some_mut(&mut [])));
    tell(k.variance(query, scratch, some_mut(&mut [])));
}

fn kernel_rows(kind: SectionKind) {
    let counts = KernelCounts::from_words(black_box([0; 8]));
    black_box((counts.words(), counts.has(kind), counts.section_bytes(kind)));
    black_box(KernelFit::from_figures(black_box([0.0; 4])).figures());
    if let Ok(rule) = KernelRule::from_bytes(&black_box([0; KernelRule::BYTES])) {
        black_box((rule.to_bytes(), rule.query.name(), rule.normalise.name(), rule.kernel.name()));
    }
    black_box(InputRow::from_bytes(&black_box([0; InputRow::BYTES])).is_ok());
    black_box(OutputRow::from_bytes(&black_box([0; OutputRow::BYTES])).is_ok());
    black_box(InputKind::from_number(black_box(1)).map(InputKind::name));
    black_box(OutputKind::from_number(black_box(1)).map(OutputKind::name));
    black_box(black_box(EulerOrder::Xyz).name());
    if let Some(kernel) = Kernel::from_number(black_box(1), black_box(0)) {
        black_box((kernel.value(black_box(1.0)), kernel.parameter()));
    }
}

fn tell(outcome: Result<(), CallError>) {
    if let Err(error) = outcome {
        say!("{error}");
    }
}

/// Returns a slice; the compiler knows only its type.
fn some<T>(slice: &[T]) -> &[T] {
    black_box(slice)
}

/// Returns a mutable slice; the compiler knows only its type.
fn some_mut<T>(slice: &mut [T]) -> &mut [T] {
    black_box(slice)
}

/// Returns an index unknown to the compiler.
fn index() -> usize {
    black_box(0)
}

fn tables(model: &Model<&[u8]>) {
    for row in model.parts() {
        black_box((row, row.required(), row.to_bytes(), PartKind::from_number(row.kind)));
    }
    for section in model.sections() {
        black_box((section, section.row.required(), section.row.to_bytes()));
    }
    let space = model.space();
    black_box((model.blob(), model.as_bytes(), model.id(), space, space.to_bytes()));
    black_box((FileId::of(some(&[])), Axis::from_number(black_box(1)).map(Axis::name)));
    black_box(PartRow::from_bytes(&black_box([0; PartRow::BYTES])));
    black_box(SectionRow::from_bytes(&black_box([0; SectionRow::BYTES])));
    let group = GroupRow::from_bytes(&black_box([0; GroupRow::BYTES]));
    black_box((group.words(), group.scratch_len(), group.to_bytes()));
    if let Some(kind) = SectionKind::from_number(black_box(1)) {
        black_box((kind.name(), kind.elements().first().map(|own| own.name()), Element::ALL));
        counts(kind);
    }
    if let Some(kernel) = GroupKernel::from_number(black_box(8)) {
        black_box((kernel.name(), kernel.value(black_box(1.0))));
        black_box(kernel.at_rest(some::<f32>(&[]).iter().copied()));
    }
}

fn counts(kind: SectionKind) {
    if let Some(counts) = EnvelopeCounts::from_words(black_box([0; 8])) {
        black_box((counts.has(kind), counts.section_bytes(kind), counts.palette_len()));
        black_box((counts.words(), counts.predictor.name(), counts.feature_len()));
    }
    let counts = SkinCounts::from_words(black_box([0; 7]));
    black_box((counts.has(kind), counts.section_bytes(kind, index(), black_box(Element::I8))));
    black_box((counts.words(), counts.envelope()));
    black_box(NormalErrors::from_figures(black_box([0.0; 3])).figures());
    black_box(ShapeErrors::from_figures(black_box([0.0; 2])).figures());
    kernel_rows(kind);
    let counts = FilterCounts::from_words(black_box([0; 2]));
    black_box((counts.section_bytes(kind), counts.words()));
    black_box(FilterFit::from_figures(black_box([0.0; 3])).figures());
    black_box(Certificate::from_figures(black_box([0.0; 8])).figures());
}

fn numbers(envelope: Envelope<'_>) {
    let e = envelope;
    black_box([e.joint_len(), e.proxy_len(), e.palette_len(), e.group_len(), e.root(), e.part()]);
    black_box([e.scratch_len(), e.correction_len(), e.curve_len()]);
    black_box((e.stretches(), e.helper_kind(), e.helper_centre(index()), e.helper_spread(index())));
    black_box((e.name(), e.predictor(), e.certificate(), e.counts(), e.file()));
    black_box(ScratchLayout::at_once(&e));
}

fn arrays(envelope: Envelope<'_>) {
    let e = envelope;
    black_box((e.joint_name(index()), e.parent(index()), e.inverse_bind(index())));
    black_box((e.origin(index()), e.pose_range(index()), e.pose_gap(index())));
    black_box((e.stretch_range(index()), e.curve_range(index()), e.curve_name(index())));
    black_box((e.key(index()), e.c1(index(), index()), e.c2(index(), index())));
    for joint in e.evaluation_order() {
        black_box(joint);
    }
}

fn groups(envelope: Envelope<'_>) {
    for group in envelope.groups().chain(envelope.group(index())) {
        black_box([group.input_len(), group.centre_len(), group.rank()]);
        black_box((group.input(index()), group.centre(index(), index()), group.rest(index())));
        black_box((group.coefficient(index(), index()), group.output(index(), index())));
    }
}

fn evaluate(envelope: Envelope<'_>) -> Result<(), CallError> {
    let local = some::<LocalTransform>(&[]);
    let mut own = [0.0; 4];
    let (pose, palette) = (some_mut::<Matrix3x4>(&mut []), some_mut::<Matrix3x4>(&mut []));
    let (map, curves) = (some_mut::<u32>(&mut []), some::<f32>(&[]));
    let _ = black_box(envelope.bind_joints(some::<&[u8]>(&[]), map)?);
    envelope.bind_curves(some::<&[u8]>(&[]), map)?;
    gather_pose(&envelope, map, some(&[]), some(&[]).first(), pose)?;
    black_box(envelope.check_pose(pose, curves).is_ok());
    model_space_pose(&envelope, local, pose)?;
    black_box(envelope.palette(pose, curves, some_mut(&mut own), palette)?);
    black_box(envelope.base_palette(pose, curves, some_mut(&mut own), palette)?);
    let bones = some_mut::<Trs>(&mut []);
    black_box(envelope.palette_trs(pose, curves, some_mut(&mut own), palette, bones)?);
    if let (Some(entry), Some(centre)) = (palette.first(), envelope.helper_centre(index())) {
        let bone = envelope.bone(index(), entry);
        black_box(bone.map(|bone| bone.palette_entry(centre)));
    }
    black_box(envelope.rotational_palette(pose, some_mut(&mut own), palette)?);
    envelope.palettes(pose, curves, some_mut(&mut own), palette, some_mut(&mut []))
}

fn base(envelope: Envelope<'_>) -> Result<(), CallError> {
    let (pose, palette) = (some::<Matrix3x4>(&[]), some_mut::<Matrix3x4>(&mut []));
    stages::joints(&envelope, pose, palette)?;
    let (turns, strains) = (some_mut::<[[f32; 3]; 3]>(&mut []), some_mut::<[f32; 6]>(&mut []));
    stages::polar(&envelope, pose, turns, strains)?;
    let (relative, rotations) = (some_mut::<[f32; 3]>(&mut []), some_mut::<[f32; 3]>(&mut []));
    let d = some_mut::<[f32; 3]>(&mut []);
    stages::gradients(&envelope, pose, (&*turns, &*strains), relative, rotations, d)?;
    stages::palette(&envelope, &black_box([[0.0; 4]; 3]), relative, d, palette)?;
    black_box(stages::confidence(&envelope, pose, rotations, strains)?);
    Ok(())
}

fn correction(envelope: Envelope<'_>) -> Result<(), CallError> {
    let (pose, palette) = (some::<Matrix3x4>(&[]), some_mut::<Matrix3x4>(&mut []));
    let phi = some_mut::<f32>(&mut []);
    stages::features(&envelope, pose, some(&[]), some(&[]), phi)?;
    black_box(stages::correction(&envelope, pose, phi, some_mut(&mut []), palette)?);
    Ok(())
}

fn mesh(skin: Skin<'_>) {
    let s = skin;
    black_box([s.vertex_len(), s.influence_len(), s.palette_len(), s.part()]);
    black_box((s.name(), s.counts(), s.file(), s.envelope_part(), s.has_tangents()));
    black_box((s.rest_position(index()), s.rest_normal(index()), s.rest_tangent(index())));
    black_box((s.rest_box(index()), s.has_coefficients(), s.normal_errors()));
    black_box((s.shape_len(), s.shape_name(index()), s.shape_element(), s.shape_errors()));
    black_box((s.shape_delta(index(), index()), s.shape_slopes(index(), index())));
    black_box(s.shape_box(index()));
    for delta in s.deltas_of(index()) {
        black_box(delta);
    }
    for pair in s.tangent_coefficients(index()) {
        black_box(pair);
    }
    for influence in s.influences(index()) {
        black_box(influence);
    }
    for range in s.ranges() {
        black_box(range);
    }
}

/// Reads a prior and solves for pins.
#[inline(never)]
fn pinned(prior: Prior<'_>, skin: Skin<'_>) -> Result<(), CallError> {
    let counts = prior.counts();
    let counts = PriorCounts::from_words(black_box(counts.words()));
    black_box((prior.name(), prior.file(), prior.part(), prior.fit().figures()));
    black_box((prior.mean(index()), prior.weight_bounds(index())));
    black_box((prior.factor_entry(index(), index()), counts.pin_scratch_len(index())));
    if let Some(kind) = SectionKind::from_number(black_box(1)) {
        black_box(counts.section_bytes(kind));
    }
    for (pair, stiffness) in prior.symmetry() {
        black_box((pair, stiffness));
    }
    for pair in prior.cancel_pairs() {
        black_box(pair);
    }
    let mut pins = Pins::<4>::new();
    for vertex in 0..black_box(5) {
        pins.add(black_box(Pin::new(vertex, [0.5; 3])))?;
    }
    pins.add(black_box(Pin::on_screen(1, [[0.0; 4]; 2], [0.0; 2]).masked([true, false, true])))?;
    let weights = some::<f32>(&[]);
    let job = PinJob {
        palette: some(&[]),
        anchor: if black_box(true) { Anchor::Mean } else { Anchor::Current },
        beta: black_box(1.0),
        is_bounded: black_box(true),
        temporal: black_box(Some(Temporal { weights, stiffness: 1.0 })),
        symmetry: black_box(1.0),
        cancels: black_box(true),
        ..PinJob::new(prior, skin, pins.list())
    };
    black_box(job.run(some_mut(&mut []), some_mut(&mut []))?);
    black_box(skin.place(black_box(0), some(&[]), weights));
    pins.clear();
    Ok(())
}

/// Applies shapes to vertices and computes bounds.
fn shaped(skin: Skin<'_>) -> Result<(), CallError> {
    let weights = some::<f32>(&[]);
    let offsets = [index(), index(), index()];
    let [positions, normals, tangents] =
        Output::interleaved(some_mut(&mut []), index(), offsets).map(|own| black_box(Some(own)));
    let job = ShapesJob::new(skin, weights).vertices(index()..index());
    job.positions(positions).normals(normals).tangents(tangents).run()?;
    black_box(skin.shaped_bounds(some(&[]), weights)?);
    Ok(())
}

/// Skins with and without a remap and a mesh of the caller.
fn skinned(skin: Skin<'_>) -> Result<(), CallError> {
    let palette = some::<Matrix3x4>(&[]);
    let bounds = skin.bounds(palette, black_box(0.5))?;
    black_box(bounds.map(|bounds| bounds.contains(black_box([0.0; 3]))));
    skin.skin_positions(palette, some_mut(&mut []))?;
    let offsets = [index(), index(), index()];
    let [positions, normals, tangents] =
        Output::interleaved(some_mut(&mut []), index(), offsets).map(|own| black_box(Some(own)));
    let mut job = SkinJob::new(skin, palette).vertices(index()..index());
    if black_box(true) {
        job = job.remap(some(&[]));
    }
    if black_box(true) {
        job = job.rest_positions(some(&[])).rest_normals(some(&[])).rest_tangents(some(&[]));
    }
    job.positions(positions).normals(normals).tangents(tangents).run()
}
