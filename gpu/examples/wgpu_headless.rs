//! Skins three instances of a character on wgpu, as an engine would, and compares them with the CPU.
//!
//! `cargo run --release -p sinew-gpu --example wgpu_headless [-- MODEL [DRIVER]]`

use sinew_gpu::headless::{Device as _, DeviceInfo};
use sinew_gpu::layout::{Batch, Plan, Resource};
use sinew_gpu::wgpu::headless::Device;
use sinew_gpu::wgpu::{Bound, Buffers, Pipelines, limits};
use sinew_runtime::{Envelope, Matrix3x4, Model, Skin, model_space_pose};
use std::error::Error;
use wgpu::{BufferDescriptor, BufferUsages as Usage, CommandEncoderDescriptor};

const INSTANCES: usize = 3;
const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/golden/envelope-11-kernel.snw");

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = std::fs::read(arguments.next().as_deref().unwrap_or(GOLDEN))?;
    let driver = arguments.next();
    let model = Model::from_bytes(&file)?;
    let envelope = model.first::<Envelope>().ok_or("the model has no envelope")?;
    let skin = model.first::<Skin>().ok_or("the model has no skin")?;
    // An engine has its own device and queue; `headless` is for programs that have none.
    let is_wanted = |info: &DeviceInfo| driver.as_ref().is_none_or(|own| *own == info.driver);
    let headless = Device::open(is_wanted, driver.as_deref().unwrap_or("of any driver"), true)?;
    println!("{} ({})", headless.info().name, headless.info().driver_info);
    let (device, queue) = (headless.device(), headless.queue());

    // Once: the batch, its pipelines, and buffers of the sizes that the plan needs.
    let mut batch = Batch::skinned(&envelope, &skin, INSTANCES);
    batch.curves.stride = 0; // all instances share their curves
    let plan = Plan::new(&model, &envelope, &batch, &limits(&device.limits()))?;
    let pipelines = Pipelines::new(device, plan.stages())?;
    let used = [Resource::Params, Resource::Blob, Resource::Poses, Resource::Curves, Resource::Out];
    let kept = [Resource::Scratch, Resource::Palettes, Resource::Confidences];
    let owned = [&used[..], &kept].concat().into_iter().map(|resource| {
        let kind = if resource == Resource::Params { Usage::UNIFORM } else { Usage::STORAGE };
        let usage = kind | Usage::COPY_DST | Usage::COPY_SRC;
        let (label, size) = (None, plan.bytes(resource));
        let buffer = BufferDescriptor { label, size, usage, mapped_at_creation: false };
        (resource, device.create_buffer(&buffer))
    });
    let owned: Vec<_> = owned.collect();
    let [(_, params), (_, blob), (_, poses), (_, curves), (_, out), ..] = &owned[..] else {
        return Err("a buffer is missing".into());
    };
    let buffers = owned.iter().fold(Buffers::new(), |all, (own, buffer)| all.with(*own, buffer, 0));
    let bound = Bound::new(&pipelines, &plan, &buffers)?;
    queue.write_buffer(params, 0, &plan.params());
    let mut content = model.blob().to_vec();
    content.resize(plan.bytes(Resource::Blob) as usize, 0);
    queue.write_buffer(blob, 0, &content);

    // Each frame: write poses and curves, record dispatches; the engine submits.
    let posed = (0..INSTANCES).map(|n| pose(&envelope, 0.125 * n as f32));
    let posed = posed.collect::<Result<Vec<_>, _>>()?;
    let floats: Vec<f32> = posed.iter().flatten().flatten().flatten().copied().collect();
    queue.write_buffer(poses, 0, &bytes(&floats));
    let still = vec![0.0; envelope.curve_len()];
    queue.write_buffer(curves, 0, &bytes(&still));
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
    bound.encode(&mut encoder, INSTANCES)?;
    queue.submit([encoder.finish()]);

    // An engine draws from the buffers; this example reads the vertices back.
    let out = headless.read(out)?;
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut palette = vec![[[0.0; 4]; 3]; envelope.palette_len()];
    let mut skinned = vec![[0.0; 3]; skin.vertex_len()];
    let mut differing = 0;
    for (n, pose) in posed.iter().enumerate() {
        let confidence = envelope.palette(pose, &still, &mut scratch, &mut palette)?;
        skin.skin_positions(&palette, &mut skinned)?;
        println!("instance {n}: confidence {confidence:.2}, first vertex {:.3?}", skinned[0]);
        // The positions of an instance come first.
        let pairs = skinned.as_flattened().iter().zip(&out[out.len() / INSTANCES * n..]);
        differing += pairs.filter(|(cpu, gpu)| cpu.to_bits() != gpu.to_bits()).count();
    }
    println!("{differing} floats differ from the CPU's");
    Ok(())
}

/// Bends every joint about its own z axis.
fn pose(envelope: &Envelope<'_>, turn: f32) -> Result<Vec<Matrix3x4>, Box<dyn Error>> {
    let mut local: Vec<_> = envelope.rest_locals().collect();
    local.iter_mut().for_each(|joint| joint.rotation[2] += turn);
    let mut out = vec![[[0.0; 4]; 3]; local.len()];
    model_space_pose(envelope, &local, &mut out)?;
    Ok(out)
}

fn bytes(floats: &[f32]) -> Vec<u8> {
    floats.iter().flat_map(|x| x.to_le_bytes()).collect()
}
