//! What the validation layer says of wgpu's calls arrives at the counter.
#![allow(unsafe_code, reason = "only a shader that nobody has checked makes the layer speak")]

use conformance::devices::{Counter, LAVAPIPE};
use sinew_gpu::layout::Stage;
use wgpu::{
    Backends, DeviceDescriptor, ExperimentalFeatures, Features, Instance, InstanceDescriptor,
    InstanceFlags, Limits, PassthroughShaderEntryPoint, ShaderModuleDescriptorPassthrough,
};

/// Hands the driver a shader without the capability of shaders; returns how many messages were counted.
pub(crate) fn messages_of_a_broken_shader() -> usize {
    let instance = Instance::new(InstanceDescriptor {
        backends: Backends::VULKAN,
        flags: InstanceFlags::VALIDATION | InstanceFlags::DEBUG | InstanceFlags::DISCARD_HAL_LABELS,
        ..InstanceDescriptor::new_without_display_handle()
    });
    let adapters = pollster::block_on(instance.enumerate_adapters(Backends::VULKAN));
    let adapter = adapters.into_iter().find(|adapter| adapter.get_info().driver == LAVAPIPE);
    let opened = adapter.expect("lavapipe is here").request_device(&DeviceDescriptor {
        required_features: Features::PASSTHROUGH_SHADERS,
        required_limits: Limits::downlevel_defaults(),
        // SAFETY: nothing experimental is used but the shader below.
        experimental_features: unsafe { ExperimentalFeatures::enabled() },
        ..Default::default()
    });
    let (device, _) = pollster::block_on(opened).expect("lavapipe takes shaders as they are");
    let words = Stage::Joints.spirv().as_chunks::<4>().0.iter().map(|le| u32::from_le_bytes(*le));
    let mut words: Vec<u32> = words.collect();
    // Instead of the capability of shaders, the first that is declared, that of 16-bit integers.
    words[6] = 22;
    let before = Counter::message_len();
    let entry = PassthroughShaderEntryPoint { name: "main".into(), workgroup_size: (64, 1, 1) };
    // SAFETY: no pipeline is made of it; the layer reads it, and the driver keeps a copy.
    let module = unsafe {
        device.create_shader_module_passthrough(ShaderModuleDescriptorPassthrough {
            entry_points: vec![entry].into(),
            spirv: Some(words.into()),
            ..Default::default()
        })
    };
    drop(module);
    Counter::message_len() - before
}
