//! Skins three instances of a model as an engine with its own Vulkan does: its own instance,
//! device, queue, buffer and command buffer. Then compares every float with the CPU's.
//!
//!     cargo run --release -p sinew-gpu --example ash_headless -- [MODEL]
#![allow(unsafe_code, reason = "every call of Vulkan is unsafe")]

use ash::{Device, Entry, Instance, vk};
use models::cells;
use sinew_gpu::layout::{ALIGNMENT, Batch, Plan, Resource};
use sinew_gpu::vulkan::{Bound, Buffers, Pipelines, limits, pool_sizes, set_len, usage};
use sinew_runtime::skin::{Output, SkinJob};
use sinew_runtime::{
    CallError, Envelope, LocalTransform, Matrix3x4, Model, Skin, model_space_pose,
};
use std::error::Error;

const INSTANCES: usize = 3;
const GOLDEN: &[u8] = include_bytes!("../../tests/golden/envelope-11-kernel.snw");

fn main() -> Result<(), Box<dyn Error>> {
    let bytes = match std::env::args_os().nth(1) {
        Some(path) => std::fs::read(path)?,
        None => GOLDEN.to_vec(),
    };
    let model = Model::from_bytes(bytes)?;
    let envelope = model.first::<Envelope>().ok_or("the model has no envelope")?;
    let skin = model.first::<Skin>().ok_or("the model has no skin")?;
    let mut batch = Batch::skinned(&envelope, &skin, INSTANCES);
    // All instances share their curves.
    batch.curves.stride = 0;
    let poses = (0..INSTANCES).map(|n| bent(&envelope, 0.3 * n as f32));
    let poses = poses.collect::<Result<Vec<_>, _>>()?;
    let curves = curves(&envelope);
    // SAFETY: each function below uses only objects that were made before.
    let found = unsafe {
        let engine = Engine::new()?;
        let found = on_the_gpu(&engine, (&model, &envelope), &batch, &poses, &curves);
        engine.destroy();
        found?
    };
    let mut differ = 0;
    for (found, expected) in found.iter().zip(on_the_cpu(&envelope, &skin, &poses, &curves)?) {
        assert_eq!(found.len(), expected.len());
        let pairs = found.iter().zip(&expected);
        let wrong = pairs.filter(|(found, expected)| found.to_bits() != expected.to_bits());
        differ += wrong.count();
    }
    let floats: usize = found.iter().map(Vec::len).sum();
    println!("{INSTANCES} instances of {} vertices: {floats} floats", skin.vertex_len());
    println!("{differ} differ from the CPU's in any bit");
    Ok(())
}

/// Skins on the engine's device; returns palettes, confidences and skinned attributes.
unsafe fn on_the_gpu(
    engine: &Engine,
    (model, envelope): (&Model<Vec<u8>>, &Envelope<'_>),
    batch: &Batch,
    poses: &[Vec<Matrix3x4>],
    curves: &[f32],
) -> Result<[Vec<f32>; 3], Box<dyn Error>> {
    let device = &engine.device;
    let plan = Plan::new(model, envelope, batch, &limits(&engine.limits))?;

    // One buffer for all resources, each at an offset that any device can bind.
    let mut bytes = 0;
    let places = Resource::ALL.map(|resource| {
        let place = bytes;
        bytes += plan.bytes(resource).next_multiple_of(ALIGNMENT);
        place as usize
    });
    let usage = Resource::ALL.into_iter().map(usage).reduce(|a, b| a | b).unwrap_or_default();
    // SAFETY: the device is valid, and all submissions have been waited for before anything is
    // freed.
    unsafe {
        let (buffer, memory) = engine.buffer(bytes, usage)?;
        let flags = vk::MemoryMapFlags::empty();
        let mapped = device.map_memory(memory, 0, vk::WHOLE_SIZE, flags)?.cast::<u8>();
        let mapped = std::slice::from_raw_parts_mut(mapped, bytes as usize);
        let mut upload = |resource: Resource, bytes: &[u8]| {
            mapped[places[resource as usize]..][..bytes.len()].copy_from_slice(bytes);
        };
        upload(Resource::Params, &plan.params());
        upload(Resource::Blob, model.blob());
        let poses = poses.concat().concat().concat();
        for (resource, floats) in [(Resource::Poses, &poses[..]), (Resource::Curves, curves)] {
            let bytes: Vec<u8> = floats.iter().flat_map(|float| float.to_le_bytes()).collect();
            upload(resource, &bytes);
        }

        let stages: Vec<_> = plan.stages().collect();
        let pipelines = Pipelines::new(device, &stages, vk::PipelineCache::null(), None)?;
        let sizes = pool_sizes(&plan);
        let info =
            vk::DescriptorPoolCreateInfo::default().max_sets(set_len(&plan)).pool_sizes(&sizes);
        let pool = device.create_descriptor_pool(&info, None)?;
        let layouts = pipelines.set_layouts(&plan)?;
        let info =
            vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
        let sets = device.allocate_descriptor_sets(&info)?;
        let buffers = Resource::ALL.into_iter().fold(Buffers::default(), |buffers, resource| {
            let offset = places[resource as usize] as u64;
            buffers.with(resource, buffer, offset, plan.bytes(resource))
        });
        let bound = Bound::new(device, &pipelines, &plan, &buffers, &sets)?;

        // Writes of the host before a submission are visible to the device.
        engine.submit(|commands| {
            bound.record(device, commands, INSTANCES)?;
            // The engine's own barrier; here for the CPU, which reads the skinned attributes.
            let memory = [vk::MemoryBarrier::default()
                .src_access_mask(vk::AccessFlags::SHADER_WRITE)
                .dst_access_mask(vk::AccessFlags::HOST_READ)];
            let (from, to) = (vk::PipelineStageFlags::COMPUTE_SHADER, vk::PipelineStageFlags::HOST);
            let flags = vk::DependencyFlags::empty();
            device.cmd_pipeline_barrier(commands, from, to, flags, &memory, &[], &[]);
            Ok(())
        })?;

        let out = [Resource::Palettes, Resource::Confidences, Resource::Out];
        let found = out.map(|resource| {
            let bytes = &mapped[places[resource as usize]..][..plan.bytes(resource) as usize];
            bytes.as_chunks::<4>().0.iter().map(|word| f32::from_le_bytes(*word)).collect()
        });
        device.destroy_descriptor_pool(pool, None);
        pipelines.destroy(device, None);
        device.destroy_buffer(buffer, None);
        device.free_memory(memory, None);
        Ok(found)
    }
}

/// Skins on the CPU: for each instance positions, then normals, then tangents.
fn on_the_cpu(
    envelope: &Envelope<'_>,
    skin: &Skin<'_>,
    poses: &[Vec<Matrix3x4>],
    curves: &[f32],
) -> Result<[Vec<f32>; 3], Box<dyn Error>> {
    let mut out = [const { Vec::new() }; 3];
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut palette = vec![[[0.0; 4]; 3]; envelope.palette_len()];
    let v = skin.vertex_len();
    for pose in poses {
        let confidence = envelope.palette(pose, curves, &mut scratch, &mut palette)?;
        let mut skinned = vec![0.0; if skin.has_tangents() { 10 * v } else { 6 * v }];
        let floats = cells(&mut skinned);
        SkinJob::new(*skin, &palette)
            .vertices(0..v)
            .positions(Output::shared(floats, 3))
            .normals(Output::shared(&floats[3 * v..], 3))
            .tangents(skin.has_tangents().then(|| Output::shared(&floats[6 * v..], 4)))
            .run()?;
        for (all, own) in out.iter_mut().zip([palette.concat().concat(), vec![confidence], skinned])
        {
            all.extend(own);
        }
    }
    Ok(out)
}

/// Rotates each joint from its rest frame by an angle about its own z axis.
fn bent(envelope: &Envelope<'_>, angle: f32) -> Result<Vec<Matrix3x4>, CallError> {
    let (s, c) = (angle / 2.0).sin_cos();
    let turned = |rest: LocalTransform| {
        let [x, y, z, w] = rest.rotation;
        LocalTransform {
            rotation: [c * x + s * y, c * y - s * x, c * z + s * w, c * w - s * z],
            ..rest
        }
    };
    let local: Vec<_> = envelope.rest_locals().map(turned).collect();
    let mut pose = vec![Matrix3x4::default(); local.len()];
    model_space_pose(envelope, &local, &mut pose)?;
    Ok(pose)
}

/// Returns the greatest trained value of each curve.
fn curves(envelope: &Envelope<'_>) -> Vec<f32> {
    let ranges = (0..envelope.curve_len()).filter_map(|curve| envelope.curve_range(curve));
    ranges.map(|[_, most]| most).collect()
}

/// The Vulkan objects that an engine already has.
struct Engine {
    instance: Instance,
    device: Device,
    queue: vk::Queue,
    commands: vk::CommandPool,
    limits: vk::PhysicalDeviceLimits,
    memory: vk::PhysicalDeviceMemoryProperties,
    /// Keeps the loader's library loaded.
    _entry: Entry,
}

impl Engine {
    unsafe fn new() -> Result<Self, Box<dyn Error>> {
        // SAFETY: each call uses objects that earlier calls have made.
        unsafe {
            let entry = Entry::load()?;
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_1);
            let info = vk::InstanceCreateInfo::default().application_info(&application);
            let instance = entry.create_instance(&info, None)?;
            let physical = instance.enumerate_physical_devices()?;
            let physical = *physical.first().ok_or("no Vulkan device")?;
            let properties = instance.get_physical_device_properties(physical);
            println!("on {}", properties.device_name_as_c_str()?.to_string_lossy());
            let families = instance.get_physical_device_queue_family_properties(physical);
            let compute = families
                .iter()
                .position(|family| family.queue_flags.contains(vk::QueueFlags::COMPUTE));
            let family = compute.ok_or("no queue family has compute")? as u32;
            let queues = [vk::DeviceQueueCreateInfo::default()
                .queue_family_index(family)
                .queue_priorities(&[1.0])];
            let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
            let device = instance.create_device(physical, &info, None)?;
            let info = vk::CommandPoolCreateInfo::default().queue_family_index(family);
            Ok(Self {
                queue: device.get_device_queue(family, 0),
                commands: device.create_command_pool(&info, None)?,
                limits: properties.limits,
                memory: instance.get_physical_device_memory_properties(physical),
                device,
                instance,
                _entry: entry,
            })
        }
    }

    /// Makes a buffer in host-visible memory.
    unsafe fn buffer(
        &self,
        bytes: u64,
        usage: vk::BufferUsageFlags,
    ) -> Result<(vk::Buffer, vk::DeviceMemory), Box<dyn Error>> {
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage);
        // SAFETY: each call uses objects that earlier calls have made.
        unsafe {
            let buffer = self.device.create_buffer(&info, None)?;
            let asked = self.device.get_buffer_memory_requirements(buffer);
            let seen =
                vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
            let mut types = self.memory.memory_types_as_slice().iter().zip(0..);
            let fits = types.find(|(kind, index)| {
                asked.memory_type_bits >> index & 1 == 1 && kind.property_flags.contains(seen)
            });
            let (_, index) = fits.ok_or("no memory that the host sees")?;
            let info = vk::MemoryAllocateInfo::default()
                .allocation_size(asked.size)
                .memory_type_index(index);
            let memory = self.device.allocate_memory(&info, None)?;
            self.device.bind_buffer_memory(buffer, memory, 0)?;
            Ok((buffer, memory))
        }
    }

    /// Records, submits and waits.
    unsafe fn submit(
        &self,
        record: impl FnOnce(vk::CommandBuffer) -> Result<(), Box<dyn Error>>,
    ) -> Result<(), Box<dyn Error>> {
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(self.commands)
            .command_buffer_count(1);
        // SAFETY: each call uses objects that earlier calls have made.
        unsafe {
            let commands = self.device.allocate_command_buffers(&info)?;
            let begin = vk::CommandBufferBeginInfo::default();
            self.device.begin_command_buffer(commands[0], &begin)?;
            record(commands[0])?;
            self.device.end_command_buffer(commands[0])?;
            let submits = [vk::SubmitInfo::default().command_buffers(&commands)];
            self.device.queue_submit(self.queue, &submits, vk::Fence::null())?;
            Ok(self.device.queue_wait_idle(self.queue)?)
        }
    }

    unsafe fn destroy(self) {
        // SAFETY: their objects have been destroyed, and nothing is in flight.
        unsafe {
            self.device.destroy_command_pool(self.commands, None);
            self.device.destroy_device(None);
            self.instance.destroy_instance(None);
        }
    }
}
