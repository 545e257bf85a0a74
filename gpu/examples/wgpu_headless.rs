//! Skins three instances of a model on wgpu, as an engine would, and compares the result with the
//! CPU's.
//!
//! `cargo run --release -p sinew-gpu --example wgpu_headless [-- MODEL [DRIVER]]`

use sinew_gpu::headless::Device as _;
use sinew_gpu::layout::{Batch, Plan, Resource};
use sinew_gpu::wgpu::headless::Device;
use sinew_gpu::wgpu::{Bound, Buffers, Pipelines, limits};
use sinew_runtime::{Envelope, LocalTransform, Matrix3x4, Model, model_space_pose};
use std::error::Error;
use wgpu::{BufferDescriptor, BufferUsages, CommandEncoderDescriptor};

const INSTANCES: usize = 3;
const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/golden/envelope-9-kernel.snw");

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = std::fs::read(arguments.next().as_deref().unwrap_or(GOLDEN))?;
    let driver = arguments.next();
    let model = Model::from_bytes(&file)?;
    let envelope = model.envelope().ok_or("the model has no envelope")?;
    let skin = model.skin().ok_or("the model has no skin")?;

    // An engine has its own device and queue; `headless` is for programs that have none.
    let wanted = |driver: Option<&str>, found: &str| driver.is_none_or(|driver| driver == found);
    let name = driver.as_deref().unwrap_or("of any driver");
    let headless = Device::open(|info| wanted(driver.as_deref(), &info.driver), name, true)?;
    println!("{} ({})", headless.info().name, headless.info().driver_info);
    let (device, queue) = (headless.device(), headless.queue());

    // Once: the batch, its pipelines, and buffers of the sizes that the plan needs.
    let mut batch = Batch::skinned(&envelope, &skin, INSTANCES);
    // All instances share their curves.
    batch.curves.stride = 0;
    let plan = Plan::new(&model, &envelope, &batch, &limits(&device.limits()))?;
    let pipelines = Pipelines::new(device, plan.stages())?;
    let buffer = |resource, usage| {
        let (label, size) = (None, plan.bytes(resource));
        device.create_buffer(&BufferDescriptor { label, size, usage, mapped_at_creation: false })
    };
    let input = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let output = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let params = buffer(Resource::Params, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
    let blob = buffer(Resource::Blob, input);
    let posed = buffer(Resource::Poses, input);
    let curved = buffer(Resource::Curves, input);
    let scratch = buffer(Resource::Scratch, BufferUsages::STORAGE);
    let palettes = buffer(Resource::Palettes, output);
    let confidences = buffer(Resource::Confidences, output);
    let out = buffer(Resource::Out, output);
    queue.write_buffer(&params, 0, &plan.params());
    let mut content = model.blob().to_vec();
    content.resize(plan.bytes(Resource::Blob) as usize, 0);
    queue.write_buffer(&blob, 0, &content);
    let buffers = Buffers::new()
        .with(Resource::Params, &params, 0)
        .with(Resource::Blob, &blob, 0)
        .with(Resource::Poses, &posed, 0)
        .with(Resource::Curves, &curved, 0)
        .with(Resource::Scratch, &scratch, 0)
        .with(Resource::Palettes, &palettes, 0)
        .with(Resource::Confidences, &confidences, 0)
        .with(Resource::Out, &out, 0);
    let bound = Bound::new(&pipelines, &plan, &buffers)?;

    // Each frame: write poses and curves, record dispatches; the engine submits.
    let poses = (0..INSTANCES).map(|n| pose(&envelope, 0.25 * n as f32));
    let poses = poses.collect::<Result<Vec<_>, _>>()?;
    let floats = poses.iter().flatten().flatten().flatten();
    let bytes: Vec<u8> = floats.flat_map(|x| x.to_le_bytes()).collect();
    queue.write_buffer(&posed, 0, &bytes);
    let curves = curves(&envelope);
    let bytes: Vec<u8> = curves.iter().flat_map(|x| x.to_le_bytes()).collect();
    queue.write_buffer(&curved, 0, &bytes);
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
    bound.encode(&mut encoder, INSTANCES)?;
    queue.submit([encoder.finish()]);

    // An engine draws from the buffers; this example reads them back.
    let palettes = headless.read(&palettes)?;
    let confidences = headless.read(&confidences)?;
    let out = headless.read(&out)?;
    let mut differing = 0;
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut palette = vec![[[0.0; 4]; 3]; envelope.palette_len()];
    let mut skinned = vec![[0.0; 3]; skin.vertex_len()];
    for (n, pose) in poses.iter().enumerate() {
        let confidence = envelope.palette(pose, &curves, &mut scratch, &mut palette)?;
        skin.skin_positions(&palette, &mut skinned)?;
        let cpu = palette.as_flattened().as_flattened();
        let gpu = &palettes[12 * palette.len() * n..];
        differing += bits(cpu, gpu);
        let cpu = skinned.as_flattened();
        // The positions of an instance come first.
        let gpu = &out[out.len() / INSTANCES * n..][..cpu.len()];
        differing += bits(cpu, gpu) + bits(&[confidence], &confidences[n..]);
        let (low, high) = bounds(gpu);
        println!("instance {n}: confidence {confidence:.2}, from {low:.3?} to {high:.3?}");
    }
    println!("{differing} bits differ from the CPU's");
    Ok(())
}

/// Rotates every joint about its own z axis.
fn pose(envelope: &Envelope<'_>, angle: f32) -> Result<Vec<Matrix3x4>, Box<dyn Error>> {
    let (s, c) = (angle / 2.0).sin_cos();
    let turned = |rest: LocalTransform| {
        let [x, y, z, w] = rest.rotation;
        LocalTransform {
            rotation: [c * x + s * y, c * y - s * x, c * z + s * w, c * w - s * z],
            ..rest
        }
    };
    let local: Vec<_> = envelope.rest_locals().map(turned).collect();
    let mut out = vec![[[0.0; 4]; 3]; local.len()];
    model_space_pose(envelope, &local, &mut out)?;
    Ok(out)
}

/// Returns the greatest trained value of each curve.
fn curves(envelope: &Envelope<'_>) -> Vec<f32> {
    let ranges = (0..envelope.curve_len()).filter_map(|curve| envelope.curve_range(curve));
    ranges.map(|[_, most]| most).collect()
}

/// Counts the bits in which `some` differs from the start of `others`.
fn bits(some: &[f32], others: &[f32]) -> u32 {
    some.iter().zip(others).map(|(a, b)| (a.to_bits() ^ b.to_bits()).count_ones()).sum()
}

/// Returns the corners of the bounding box of points.
fn bounds(points: &[f32]) -> ([f32; 3], [f32; 3]) {
    let points = points.as_chunks::<3>().0.iter();
    points.fold(([f32::MAX; 3], [f32::MIN; 3]), |(low, high), point| {
        ([0, 1, 2].map(|i| low[i].min(point[i])), [0, 1, 2].map(|i| high[i].max(point[i])))
    })
}
