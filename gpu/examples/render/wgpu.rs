//! The picture through wgpu.

use crate::Result;
use crate::scene::{BACKGROUND, HEIGHT, INSTANCES, SHADER, Scene, WIDTH};
use ::wgpu::util::DeviceExt;
use ::wgpu::{
    BindGroup, Buffer, BufferDescriptor, BufferUsages, Color, CompareFunction, DepthStencilState,
    Device, Extent3d, FragmentState, IndexFormat, LoadOp, Operations, PrimitiveState,
    RenderPassColorAttachment, RenderPassDepthStencilAttachment, RenderPassDescriptor,
    RenderPipeline, RenderPipelineDescriptor, ShaderModuleDescriptor, ShaderSource, StoreOp,
    TexelCopyBufferInfo, TexelCopyBufferLayout, TextureDescriptor, TextureDimension, TextureFormat,
    TextureUsages, VertexState,
};
use sinew_gpu::layout::Resource;
use sinew_gpu::wgpu::headless::Device as Headless;
use sinew_gpu::wgpu::{Bound, Buffers, Pipelines, limits};

const COLOUR: TextureFormat = TextureFormat::Rgba8UnormSrgb;
const DEPTH: TextureFormat = TextureFormat::Depth32Float;
const SIZE: Extent3d = Extent3d { width: WIDTH, height: HEIGHT, depth_or_array_layers: 1 };

/// Renders the scene on the first device; returns rows of RGBA8, from the top.
pub(crate) fn render(scene: &Scene) -> Result<Vec<u8>> {
    let headless = Headless::open(|_| true, "of any driver", true)?;
    let device = headless.device();
    let plan = scene.plan(&limits(&device.limits()))?;

    let filled = |contents: &[u8], usage| {
        let label = None;
        device.create_buffer_init(&::wgpu::util::BufferInitDescriptor { label, contents, usage })
    };
    let empty = |size, usage| {
        let label = None;
        device.create_buffer(&BufferDescriptor { label, size, usage, mapped_at_creation: false })
    };
    let params = filled(&plan.params(), BufferUsages::UNIFORM);
    let blob = filled(scene.model.blob(), BufferUsages::STORAGE);
    let poses = filled(&bytes(&scene.poses), BufferUsages::STORAGE);
    let scratch = empty(plan.bytes(Resource::Scratch), BufferUsages::STORAGE);
    let palettes = empty(plan.bytes(Resource::Palettes), BufferUsages::STORAGE);
    let buffers = Buffers::new()
        .with(Resource::Params, &params, 0)
        .with(Resource::Blob, &blob, 0)
        .with(Resource::Poses, &poses, 0)
        .with(Resource::Scratch, &scratch, 0)
        .with(Resource::Palettes, &palettes, 0);
    let pipelines = Pipelines::new(device, plan.stages())?;
    let bound = Bound::new(&pipelines, &plan, &buffers)?;

    let pipeline = pipeline(device);
    let camera = filled(&bytes(&scene.camera), BufferUsages::UNIFORM);
    let group = group(device, &pipeline, [&params, &blob, &palettes, &camera]);
    let indices: Vec<u8> = scene.indices.iter().flat_map(|index| index.to_le_bytes()).collect();
    let indices = filled(&indices, BufferUsages::INDEX);
    let target = |format, usage| {
        device.create_texture(&TextureDescriptor {
            label: None,
            size: SIZE,
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format,
            usage: TextureUsages::RENDER_ATTACHMENT | usage,
            view_formats: &[],
        })
    };
    let colour = target(COLOUR, TextureUsages::COPY_SRC);
    let depth = target(DEPTH, TextureUsages::empty());
    // A row is a multiple of 256 bytes, as wgpu requires.
    let row_bytes = 4 * WIDTH;
    let pixels =
        empty(u64::from(row_bytes * HEIGHT), BufferUsages::COPY_DST | BufferUsages::COPY_SRC);

    headless.submit(|encoder| {
        bound.encode(encoder, INSTANCES)?;
        let [r, g, b, a] = BACKGROUND;
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            color_attachments: &[Some(RenderPassColorAttachment {
                view: &colour.create_view(&Default::default()),
                depth_slice: None,
                resolve_target: None,
                ops: Operations {
                    load: LoadOp::Clear(Color { r, g, b, a }),
                    store: StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: &depth.create_view(&Default::default()),
                depth_ops: Some(Operations { load: LoadOp::Clear(1.0), store: StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_index_buffer(indices.slice(..), IndexFormat::Uint32);
        pass.draw_indexed(0..scene.indices.len() as u32, 0, 0..INSTANCES as u32);
        drop(pass);
        let layout = TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row_bytes),
            rows_per_image: None,
        };
        let buffer = TexelCopyBufferInfo { buffer: &pixels, layout };
        encoder.copy_texture_to_buffer(colour.as_image_copy(), buffer, SIZE);
        Ok(())
    })?;
    Ok(headless.read_bytes(&pixels)?)
}

fn pipeline(device: &Device) -> RenderPipeline {
    let source = ShaderSource::Wgsl(SHADER.into());
    let module =
        device.create_shader_module(ShaderModuleDescriptor { label: Some("host"), source });
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some("host"),
        layout: None,
        vertex: VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: PrimitiveState::default(),
        depth_stencil: Some(DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(CompareFunction::Less),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(FragmentState {
            module: &module,
            entry_point: Some("fragment"),
            compilation_options: Default::default(),
            targets: &[Some(COLOUR.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn group(device: &Device, pipeline: &RenderPipeline, own: [&Buffer; 4]) -> BindGroup {
    let entries = own.iter().zip(0..).map(|(buffer, binding)| ::wgpu::BindGroupEntry {
        binding,
        resource: buffer.as_entire_binding(),
    });
    let entries: Vec<_> = entries.collect();
    device.create_bind_group(&::wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    })
}

fn bytes(floats: &[f32]) -> Vec<u8> {
    floats.iter().flat_map(|x| x.to_le_bytes()).collect()
}
