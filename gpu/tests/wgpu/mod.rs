//! The stages on wgpu: compared with the CPU's bits, and with a host's mistakes.

mod allocations;
mod bits;
mod refusals;
mod snippets;

use crate::common::{
    GOLDEN_STRETCH, filter_plan, kernel_plan, load, parts, remapped_batch, shapes_plan,
};
use sinew_gpu::headless::Device as _;
use sinew_gpu::layout::{Batch, DeviceLimits, Plan, Resource, Stage};
use sinew_gpu::wgpu::headless::Device;
use sinew_gpu::wgpu::{Bound, Buffers, Error, Pipelines};
use sinew_runtime::{Envelope, Skin};
use wgpu::{Buffer, BufferDescriptor, BufferUsages};

fn lavapipe() -> Device {
    Device::of_driver("llvmpipe", true)
        .unwrap_or_else(|error| panic!("{error}; install mesa-vulkan-drivers"))
}

/// A batch with one buffer for each resource.
struct Scene {
    device: Device,
    pipelines: Pipelines,
    plan: Plan,
    own: Vec<Buffer>,
}

const COPIED: BufferUsages = BufferUsages::COPY_SRC.union(BufferUsages::COPY_DST);

/// Only palettes, of three instances.
fn palettes(envelope: &Envelope<'_>, _: &Skin<'_>) -> Batch {
    Batch { confidences: None, ..Batch::palettes(envelope, 3) }
}

/// Three instances that need every resource.
fn whole(envelope: &Envelope<'_>, skin: &Skin<'_>) -> Batch {
    remapped_batch(envelope, skin, 3)
}

fn scene(bytes: &[u8], batch: impl Fn(&Envelope<'_>, &Skin<'_>) -> Batch) -> Scene {
    let model = load(bytes);
    let (envelope, skin) = parts(&model);
    scene_of(|limits| {
        let batch = batch(&envelope, &skin);
        let plan = Plan::new(&model, &envelope, &batch, limits).unwrap();
        (plan, model.blob().to_vec())
    })
}

/// Scenes of every kind of batch; together they need every resource.
fn scenes() -> [Scene; 4] {
    let scenes = [
        scene(GOLDEN_STRETCH[1], whole),
        scene_of(kernel_plan),
        scene_of(shapes_plan),
        scene_of(filter_plan),
    ];
    assert!(Resource::ALL.into_iter().all(|own| scenes.iter().any(|scene| scene.needs(own))));
    scenes
}

fn scene_of(plan: impl Fn(&DeviceLimits) -> (Plan, Vec<u8>)) -> Scene {
    let device = lavapipe();
    let (plan, mut blob) = plan(&device.limits());
    let pipelines = Pipelines::new(device.device(), Stage::ALL).unwrap();
    let own = Resource::ALL.map(|resource| {
        let kind = match resource {
            Resource::Params => BufferUsages::UNIFORM,
            _ => BufferUsages::STORAGE,
        };
        buffer(device.device(), plan.bytes(resource).max(4), kind | COPIED)
    });
    device.queue().write_buffer(&own[Resource::Params as usize], 0, &plan.params());
    blob.resize(plan.bytes(Resource::Blob) as usize, 0);
    device.queue().write_buffer(&own[Resource::Blob as usize], 0, &blob);
    Scene { device, pipelines, plan, own: own.into() }
}

fn buffer(device: &wgpu::Device, size: u64, usage: BufferUsages) -> Buffer {
    device.create_buffer(&BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
}

impl Scene {
    fn buffers(&self) -> Buffers<'_> {
        let all = Resource::ALL.into_iter().zip(&self.own);
        all.fold(Buffers::new(), |buffers, (resource, own)| buffers.with(resource, own, 0))
    }

    fn needs(&self, resource: Resource) -> bool {
        self.plan.bytes(resource) > 0
    }

    fn needed(&self) -> impl Iterator<Item = Resource> {
        Resource::ALL.into_iter().filter(|resource| self.needs(*resource))
    }

    fn refused(&self, buffers: &Buffers<'_>) -> Error {
        Bound::new(&self.pipelines, &self.plan, buffers).map(drop).unwrap_err()
    }

    fn make(&self, size: u64, usage: BufferUsages) -> Buffer {
        buffer(self.device.device(), size, usage)
    }
}
