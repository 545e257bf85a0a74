//! The runtime's stages on wgpu and on raw Vulkan. Empty until the GPU work begins.
