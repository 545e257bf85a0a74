//! The picture through the host's own Vulkan.
#![allow(unsafe_code, reason = "every call of Vulkan is unsafe")]

use crate::Result;
use crate::scene::{BACKGROUND, HEIGHT, INSTANCES, SHADER, Scene, WIDTH};
use crate::target::Target;
use ash::vk::{self, AccessFlags as Access, PipelineStageFlags as Stages};
use sinew_gpu::headless::{Device as _, Uploaded};
use sinew_gpu::layout::Resource;
use sinew_gpu::vulkan::headless::{Commands, Device, Memory, VulkanBatch};

/// Renders the scene on the first device; returns rows of RGBA8, from the top.
pub(crate) fn render(scene: &Scene) -> Result<Vec<u8>> {
    // With the validation layer if it is installed.
    let open = |validation| Device::open(|_| true, "of any driver", validation);
    let headless = open(true).or_else(|_| open(false))?;
    let plan = scene.plan(&headless.limits())?;
    let mut batch = headless.batch(scene.model.blob(), &plan)?;
    batch.write(Resource::Poses, 0, &scene.poses)?;
    let pixels = draw(&headless, &batch, scene)?;
    match headless.messages().unwrap_or_default() {
        messages if messages.is_empty() => Ok(pixels),
        messages => Err(messages.join("\n").into()),
    }
}

/// Computes the palettes, and draws with them in the same command buffer.
fn draw(headless: &Device, batch: &VulkanBatch<'_>, scene: &Scene) -> Result<Vec<u8>> {
    let mut camera = Memory::staging(headless, 64, vk::BufferUsageFlags::UNIFORM_BUFFER)?;
    let floats: Vec<u8> = scene.camera.iter().flat_map(|float| float.to_le_bytes()).collect();
    camera.fill(&floats)?;
    let bytes: Vec<u8> = scene.indices.iter().flat_map(|index| index.to_le_bytes()).collect();
    let usage = vk::BufferUsageFlags::INDEX_BUFFER;
    let mut indices = Memory::staging(headless, bytes.len() as u64, usage)?;
    indices.fill(&bytes)?;
    let mut pixels = vec![0; 4 * (WIDTH * HEIGHT) as usize];
    let copy = Memory::staging(headless, pixels.len() as u64, vk::BufferUsageFlags::empty())?;
    let target = Target::new(headless)?;
    let buffers = [
        batch.memory(Resource::Params)?,
        batch.memory(Resource::Blob)?,
        batch.memory(Resource::Palettes)?,
        &camera,
    ];
    let host = Host::new(headless, &target, buffers.map(Memory::buffer))?;
    let commands = Commands::new(headless)?;
    let record = |device: &ash::Device, commands: vk::CommandBuffer| {
        let barrier = |before: (Stages, Access), after: (Stages, Access)| {
            let memory =
                [vk::MemoryBarrier::default().src_access_mask(before.1).dst_access_mask(after.1)];
            let none = vk::DependencyFlags::empty();
            // SAFETY: the command buffer is being recorded.
            unsafe {
                device.cmd_pipeline_barrier(commands, before.0, after.0, none, &memory, &[], &[]);
            }
        };
        // Makes uploads visible to all shaders.
        barrier(
            (Stages::TRANSFER, Access::TRANSFER_WRITE),
            (
                Stages::COMPUTE_SHADER | Stages::VERTEX_SHADER,
                Access::SHADER_READ | Access::SHADER_WRITE | Access::UNIFORM_READ,
            ),
        );
        // SAFETY: the barrier above is the one that `record` requires.
        unsafe { batch.bound().record(device, commands, INSTANCES) }?;
        // Makes palettes visible to the host's vertex shader.
        barrier(
            (Stages::COMPUTE_SHADER, Access::SHADER_WRITE),
            (Stages::VERTEX_SHADER, Access::SHADER_READ),
        );
        // SAFETY: all objects live until the commands have been waited for.
        unsafe {
            target.begin(device, commands, BACKGROUND.map(|x| x as f32));
            host.bind(device, commands);
            device.cmd_bind_index_buffer(commands, indices.buffer(), 0, vk::IndexType::UINT32);
            let count = scene.indices.len() as u32;
            device.cmd_draw_indexed(commands, count, INSTANCES as u32, 0, 0, 0);
            target.end(device, commands, copy.buffer());
        }
        barrier((Stages::TRANSFER, Access::TRANSFER_WRITE), (Stages::HOST, Access::HOST_READ));
        Ok(())
    };
    // SAFETY: the recorded commands are valid.
    unsafe { commands.submit(record) }?;
    copy.copy(&mut pixels)?;
    Ok(pixels)
}

/// The host's own pipeline and its bindings.
struct Host<'d> {
    device: &'d ash::Device,
    set_layout: vk::DescriptorSetLayout,
    layout: vk::PipelineLayout,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
    pipeline: vk::Pipeline,
}

impl<'d> Host<'d> {
    /// Makes the pipeline, and binds params, blob, palettes and camera.
    fn new(headless: &'d Device, target: &Target<'_>, buffers: [vk::Buffer; 4]) -> Result<Self> {
        let mut host = Self {
            device: headless.device(),
            set_layout: vk::DescriptorSetLayout::null(),
            layout: vk::PipelineLayout::null(),
            pool: vk::DescriptorPool::null(),
            set: vk::DescriptorSet::null(),
            pipeline: vk::Pipeline::null(),
        };
        const UNIFORM: vk::DescriptorType = vk::DescriptorType::UNIFORM_BUFFER;
        const STORAGE: vk::DescriptorType = vk::DescriptorType::STORAGE_BUFFER;
        let types = [UNIFORM, STORAGE, STORAGE, UNIFORM];
        let bindings: Vec<_> = (0..)
            .zip(types)
            .map(|(number, kind)| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(number)
                    .descriptor_type(kind)
                    .descriptor_count(1)
                    .stage_flags(vk::ShaderStageFlags::VERTEX)
            })
            .collect();
        let sizes = [UNIFORM, STORAGE]
            .map(|kind| vk::DescriptorPoolSize::default().ty(kind).descriptor_count(2));
        // SAFETY: each call uses objects that earlier calls have made.
        unsafe {
            let device = host.device;
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            host.set_layout = device.create_descriptor_set_layout(&info, None)?;
            let layouts = [host.set_layout];
            let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&layouts);
            host.layout = device.create_pipeline_layout(&info, None)?;
            let info = vk::DescriptorPoolCreateInfo::default().pool_sizes(&sizes).max_sets(1);
            host.pool = device.create_descriptor_pool(&info, None)?;
            let info = vk::DescriptorSetAllocateInfo::default()
                .descriptor_pool(host.pool)
                .set_layouts(&layouts);
            host.set = device.allocate_descriptor_sets(&info)?[0];
            for ((number, kind), buffer) in (0..).zip(types).zip(buffers) {
                let info =
                    [vk::DescriptorBufferInfo::default().buffer(buffer).range(vk::WHOLE_SIZE)];
                let write = vk::WriteDescriptorSet::default()
                    .dst_set(host.set)
                    .dst_binding(number)
                    .descriptor_type(kind)
                    .buffer_info(&info);
                device.update_descriptor_sets(&[write], &[]);
            }
            host.pipeline = pipeline(device, host.layout, target.pass())?;
        }
        Ok(host)
    }

    /// # Safety
    /// The command buffer must be recording inside the target's render pass.
    unsafe fn bind(&self, device: &ash::Device, commands: vk::CommandBuffer) {
        const DRAWS: vk::PipelineBindPoint = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: as our own caller promises.
        unsafe {
            device.cmd_bind_pipeline(commands, DRAWS, self.pipeline);
            device.cmd_bind_descriptor_sets(commands, DRAWS, self.layout, 0, &[self.set], &[]);
        }
    }
}

impl Drop for Host<'_> {
    fn drop(&mut self) {
        // SAFETY: commands that use them have been waited for.
        unsafe {
            self.device.destroy_pipeline(self.pipeline, None);
            self.device.destroy_descriptor_pool(self.pool, None);
            self.device.destroy_pipeline_layout(self.layout, None);
            self.device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

unsafe fn pipeline(
    device: &ash::Device,
    layout: vk::PipelineLayout,
    pass: vk::RenderPass,
) -> Result<vk::Pipeline> {
    let words = spirv()?;
    let info = vk::ShaderModuleCreateInfo::default().code(&words);
    // SAFETY: naga has validated the shader.
    let module = unsafe { device.create_shader_module(&info, None) }?;
    let shader = |stage, name| {
        vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module).name(name)
    };
    let shaders = [
        shader(vk::ShaderStageFlags::VERTEX, c"vertex"),
        shader(vk::ShaderStageFlags::FRAGMENT, c"fragment"),
    ];
    let input = vk::PipelineVertexInputStateCreateInfo::default();
    let triangles = vk::PipelineInputAssemblyStateCreateInfo::default()
        .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
    // The negative height turns y upwards, as in wgpu's clip space.
    let (width, height) = (WIDTH as f32, HEIGHT as f32);
    let viewports = [vk::Viewport::default().y(height).width(width).height(-height).max_depth(1.0)];
    let scissors = [vk::Extent2D { width: WIDTH, height: HEIGHT }.into()];
    let view =
        vk::PipelineViewportStateCreateInfo::default().viewports(&viewports).scissors(&scissors);
    let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
    let samples = vk::PipelineMultisampleStateCreateInfo::default()
        .rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let depth = vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(true)
        .depth_write_enable(true)
        .depth_compare_op(vk::CompareOp::LESS);
    let colours = [vk::PipelineColorBlendAttachmentState::default()
        .color_write_mask(vk::ColorComponentFlags::RGBA)];
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&colours);
    let info = vk::GraphicsPipelineCreateInfo::default()
        .stages(&shaders)
        .vertex_input_state(&input)
        .input_assembly_state(&triangles)
        .viewport_state(&view)
        .rasterization_state(&raster)
        .multisample_state(&samples)
        .depth_stencil_state(&depth)
        .color_blend_state(&blend)
        .layout(layout)
        .render_pass(pass);
    let cache = vk::PipelineCache::null();
    // SAFETY: all pointers live through the calls.
    unsafe {
        let made = device.create_graphics_pipelines(cache, &[info], None);
        device.destroy_shader_module(module, None);
        Ok(made.map_err(|(_, result)| result)?[0])
    }
}

/// Translates the host's shader from WGSL to SPIR-V.
fn spirv() -> Result<Vec<u32>> {
    use naga::back::spv::{Options, WriterFlags, write_vec};
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    let module = naga::front::wgsl::parse_str(SHADER)?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module)?;
    let options = Options { flags: WriterFlags::empty(), ..Options::default() };
    Ok(write_vec(&module, &info, &options, None)?)
}
