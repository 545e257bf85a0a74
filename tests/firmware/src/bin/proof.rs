//! Calls all of the runtime with arguments that the compiler knows nothing of, and links only
//! if none of it can panic.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use core::hint::black_box;
use firmware::say;
use sinew_runtime::envelope::{
    Attribute, Buffer, SkinJob, confidence, correction, gradients, joints, palette,
};
use sinew_runtime::format::{GroupRow, PartRow, SectionRow, checksum};
use sinew_runtime::kernel::Kernel;
use sinew_runtime::pose::features;
use sinew_runtime::{
    Envelope, EvalError, Limits, LocalTransform, Matrix3x4, Model, Workspace, model_space_pose,
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
    tables(model);
    let name = core::str::from_utf8(bytes).unwrap_or_default();
    for envelope in [model.envelope(), model.envelope_named(name)].into_iter().flatten() {
        numbers(envelope);
        arrays(envelope);
        groups(envelope);
        for outcome in [evaluate(envelope), base(envelope), stages(envelope)] {
            if let Err(error) = outcome {
                say!("{error}");
            }
        }
    }
    true
}

/// Returns a slice of which only the type is known.
fn some<T>(slice: &[T]) -> &[T] {
    black_box(slice)
}

/// Likewise, to write to.
fn some_mut<T>(slice: &mut [T]) -> &mut [T] {
    black_box(slice)
}

/// Any index.
fn index() -> usize {
    black_box(0)
}

fn tables(model: Model<'_>) {
    for row in model.parts() {
        black_box((row, row.required(), row.to_bytes(), row.envelope_counts(), row.certificate()));
    }
    for section in model.sections() {
        black_box((section, section.row.to_bytes()));
    }
    black_box((model.blob(), PartRow::from_bytes(&black_box([0; PartRow::BYTES]))));
    black_box(SectionRow::from_bytes(&black_box([0; SectionRow::BYTES])));
    let group = GroupRow::from_bytes(&black_box([0; GroupRow::BYTES]));
    black_box((group.words(), group.scratch_len(), group.to_bytes()));
    if let Some(kernel) = Kernel::from_number(black_box(8)) {
        black_box((kernel.name(), kernel.value(black_box(1.0))));
        black_box(kernel.at_rest(some::<f32>(&[]).iter().copied()));
    }
}

fn numbers(envelope: Envelope<'_>) {
    let e = envelope;
    black_box([e.vertex_len(), e.joint_len(), e.proxy_len(), e.palette_len(), e.group_len()]);
    black_box([e.scratch_len(), e.influence_len(), e.workspace_len(), e.root(), e.part()]);
    black_box((e.name(), e.predictor(), e.certificate(), e.has_tangents()));
}

fn arrays(envelope: Envelope<'_>) {
    let e = envelope;
    black_box((e.joint_name(index()), e.parent(index()), e.inverse_bind(index())));
    black_box((e.origin(index()), e.pose_range(index()), e.rest_position(index())));
    black_box((e.rest_normal(index()), e.rest_tangent(index()), e.rest_box(index())));
    black_box((e.key(index()), e.c1(index(), index()), e.c2(index(), index())));
    for influence in e.influences(index()) {
        black_box(influence);
    }
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

fn evaluate(envelope: Envelope<'_>) -> Result<(), EvalError> {
    let local = some::<LocalTransform>(&[]);
    let mut own = Workspace::<4>::new();
    let (pose, maps) = (some_mut::<Matrix3x4>(&mut []), some_mut::<Matrix3x4>(&mut []));
    model_space_pose(&envelope, local, pose)?;
    black_box(envelope.palette(pose, some_mut(&mut own), maps)?);
    black_box(envelope.rotational_palette(pose, some_mut(&mut own), maps)?);
    black_box(envelope.bounds(maps)?.map(|bounds| bounds.contains(black_box([0.0; 3]))));
    envelope.skin_positions(maps, some_mut(&mut []))?;
    let attribute = || {
        let attribute = Attribute { buffer: Buffer::A, offset: index(), stride: index() };
        black_box(Some(attribute))
    };
    SkinJob {
        envelope,
        palette: maps,
        vertices: index()..index(),
        positions: attribute(),
        normals: attribute(),
        tangents: attribute(),
        out_a: some_mut(&mut []),
        out_b: some_mut(&mut []),
    }
    .run()
}

fn base(envelope: Envelope<'_>) -> Result<(), EvalError> {
    let (pose, maps) = (some::<Matrix3x4>(&[]), some_mut::<Matrix3x4>(&mut []));
    joints::evaluate(&envelope, pose, maps)?;
    let (relative, rotations) = (some_mut::<[f32; 3]>(&mut []), some_mut::<[f32; 3]>(&mut []));
    let d = some_mut::<[f32; 3]>(&mut []);
    gradients::evaluate(&envelope, pose, relative, rotations, d)?;
    palette::evaluate(&envelope, &black_box([[0.0; 4]; 3]), relative, d, maps)?;
    black_box(confidence::evaluate(&envelope, rotations)?);
    Ok(())
}

fn stages(envelope: Envelope<'_>) -> Result<(), EvalError> {
    let (pose, maps) = (some::<Matrix3x4>(&[]), some_mut::<Matrix3x4>(&mut []));
    let phi = some_mut::<Matrix3x4>(&mut []);
    features::evaluate(&envelope, pose, phi)?;
    black_box(correction::evaluate(&envelope, pose, phi, some_mut(&mut []), maps)?);
    Ok(())
}
