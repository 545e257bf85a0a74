//! The target of the host's draws: a colour and a depth image, and the render pass over them.
#![allow(unsafe_code, reason = "every call of Vulkan is unsafe")]

use crate::Result;
use crate::scene::{HEIGHT, WIDTH};
use ash::vk;
use sinew_gpu::vulkan::headless::Device;

const COLOUR: vk::Format = vk::Format::R8G8B8A8_SRGB;
const DEPTH: vk::Format = vk::Format::D32_SFLOAT;
const EXTENT: vk::Extent2D = vk::Extent2D { width: WIDTH, height: HEIGHT };

/// Freed when dropped; commands that use the target must have been waited for.
pub(crate) struct Target<'d> {
    device: &'d ash::Device,
    images: [Image; 2],
    pass: vk::RenderPass,
    framebuffer: vk::Framebuffer,
}

/// An image with its memory and view; null until they are made.
#[derive(Clone, Copy, Default)]
struct Image {
    raw: vk::Image,
    memory: vk::DeviceMemory,
    view: vk::ImageView,
}

impl<'d> Target<'d> {
    pub(crate) fn new(headless: &'d Device) -> Result<Self> {
        let mut target = Self {
            device: headless.device(),
            images: [Image::default(); 2],
            pass: vk::RenderPass::null(),
            framebuffer: vk::Framebuffer::null(),
        };
        let colour = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let depth = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
        let aspects = [vk::ImageAspectFlags::COLOR, vk::ImageAspectFlags::DEPTH];
        // SAFETY: each call uses objects that earlier calls have made.
        unsafe {
            target.images[0].make(headless, COLOUR, colour, aspects[0])?;
            target.images[1].make(headless, DEPTH, depth, aspects[1])?;
            target.pass = pass(target.device)?;
            let views = target.images.map(|image| image.view);
            let info = vk::FramebufferCreateInfo::default()
                .render_pass(target.pass)
                .attachments(&views)
                .width(WIDTH)
                .height(HEIGHT)
                .layers(1);
            target.framebuffer = target.device.create_framebuffer(&info, None)?;
        }
        Ok(target)
    }

    pub(crate) fn pass(&self) -> vk::RenderPass {
        self.pass
    }

    /// Begins the render pass on a background.
    ///
    /// # Safety
    /// The command buffer must be recording outside a render pass.
    pub(crate) unsafe fn begin(
        &self,
        device: &ash::Device,
        commands: vk::CommandBuffer,
        background: [f32; 4],
    ) {
        let depth = vk::ClearDepthStencilValue { depth: 1.0, stencil: 0 };
        let clear = [
            vk::ClearValue { color: vk::ClearColorValue { float32: background } },
            vk::ClearValue { depth_stencil: depth },
        ];
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(self.pass)
            .framebuffer(self.framebuffer)
            .render_area(EXTENT.into())
            .clear_values(&clear);
        // SAFETY: as our own caller promises.
        unsafe { device.cmd_begin_render_pass(commands, &info, vk::SubpassContents::INLINE) };
    }

    /// Ends the render pass and copies the picture to a buffer.
    ///
    /// # Safety
    /// The command buffer must be recording inside the render pass; the buffer must hold the pixels.
    pub(crate) unsafe fn end(
        &self,
        device: &ash::Device,
        commands: vk::CommandBuffer,
        out: vk::Buffer,
    ) {
        let region = vk::BufferImageCopy::default()
            .image_subresource(
                vk::ImageSubresourceLayers::default()
                    .aspect_mask(vk::ImageAspectFlags::COLOR)
                    .layer_count(1),
            )
            .image_extent(EXTENT.into());
        let (image, layout) = (self.images[0].raw, vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
        // SAFETY: as our own caller promises; the pass leaves the image in this layout.
        unsafe {
            device.cmd_end_render_pass(commands);
            device.cmd_copy_image_to_buffer(commands, image, layout, out, &[region]);
        }
    }
}

impl Drop for Target<'_> {
    fn drop(&mut self) {
        // SAFETY: commands that use them have been waited for.
        unsafe {
            self.device.destroy_framebuffer(self.framebuffer, None);
            self.device.destroy_render_pass(self.pass, None);
            for image in self.images {
                self.device.destroy_image_view(image.view, None);
                self.device.destroy_image(image.raw, None);
                self.device.free_memory(image.memory, None);
            }
        }
    }
}

impl Image {
    unsafe fn make(
        &mut self,
        headless: &Device,
        format: vk::Format,
        usage: vk::ImageUsageFlags,
        aspect: vk::ImageAspectFlags,
    ) -> Result<()> {
        let device = headless.device();
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(EXTENT.into())
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage);
        // SAFETY: each call uses objects that earlier calls have made.
        unsafe {
            self.raw = device.create_image(&info, None)?;
            let asked = device.get_image_memory_requirements(self.raw);
            let (instance, physical) = headless.physical();
            let memory = instance.get_physical_device_memory_properties(physical);
            let local = vk::MemoryPropertyFlags::DEVICE_LOCAL;
            let mut types = memory.memory_types_as_slice().iter().zip(0..);
            let fits = types.find(|(kind, index)| {
                asked.memory_type_bits >> index & 1 == 1 && kind.property_flags.contains(local)
            });
            let (_, index) = fits.ok_or("no memory for images")?;
            let info = vk::MemoryAllocateInfo::default()
                .allocation_size(asked.size)
                .memory_type_index(index);
            self.memory = device.allocate_memory(&info, None)?;
            device.bind_image_memory(self.raw, self.memory, 0)?;
            let range = vk::ImageSubresourceRange::default()
                .aspect_mask(aspect)
                .level_count(1)
                .layer_count(1);
            let info = vk::ImageViewCreateInfo::default()
                .image(self.raw)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format)
                .subresource_range(range);
            self.view = device.create_image_view(&info, None)?;
        }
        Ok(())
    }
}

/// Makes a pass that clears both images and leaves the colours ready to be copied.
unsafe fn pass(device: &ash::Device) -> Result<vk::RenderPass> {
    let attachment = |format, store, layout| {
        vk::AttachmentDescription::default()
            .format(format)
            .samples(vk::SampleCountFlags::TYPE_1)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(store)
            .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
            .stencil_store_op(vk::AttachmentStoreOp::DONT_CARE)
            .final_layout(layout)
    };
    let copied = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
    let depth_layout = vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    let attachments = [
        attachment(COLOUR, vk::AttachmentStoreOp::STORE, copied),
        attachment(DEPTH, vk::AttachmentStoreOp::DONT_CARE, depth_layout),
    ];
    let colours =
        [vk::AttachmentReference::default().layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)];
    let depth = vk::AttachmentReference::default().attachment(1).layout(depth_layout);
    let subpasses = [vk::SubpassDescription::default()
        .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
        .color_attachments(&colours)
        .depth_stencil_attachment(&depth)];
    let dependencies = [vk::SubpassDependency::default()
        .src_subpass(0)
        .dst_subpass(vk::SUBPASS_EXTERNAL)
        .src_stage_mask(vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT)
        .src_access_mask(vk::AccessFlags::COLOR_ATTACHMENT_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags::TRANSFER)
        .dst_access_mask(vk::AccessFlags::TRANSFER_READ)];
    let info = vk::RenderPassCreateInfo::default()
        .attachments(&attachments)
        .subpasses(&subpasses)
        .dependencies(&dependencies);
    // SAFETY: all pointers live through the call.
    Ok(unsafe { device.create_render_pass(&info, None) }?)
}
