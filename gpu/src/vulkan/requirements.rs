//! What the host has to make for a plan, and what of a device a plan asks for.

use crate::layout::{DeviceLimits, Plan, Resource};
use ash::vk;

/// Returns what a device's limits are in terms of the layout.
pub fn limits(device: &vk::PhysicalDeviceLimits) -> DeviceLimits {
    let alignment =
        device.min_storage_buffer_offset_alignment.max(device.min_uniform_buffer_offset_alignment);
    let [x, y, _] = device.max_compute_work_group_count;
    DeviceLimits {
        storage_binding_bytes: device.max_storage_buffer_range.into(),
        storage_buffers: device.max_per_stage_descriptor_storage_buffers,
        offset_alignment: u32::try_from(alignment).unwrap_or(u32::MAX),
        workgroup_threads: device
            .max_compute_work_group_invocations
            .min(device.max_compute_work_group_size[0]),
        workgroups: x.min(y),
    }
}

/// Returns the usage that a resource's buffer must have for us; the host adds its own, such as that
/// of an upload or of vertex input.
pub fn usage(resource: Resource) -> vk::BufferUsageFlags {
    match resource {
        Resource::Params => vk::BufferUsageFlags::UNIFORM_BUFFER,
        _ => vk::BufferUsageFlags::STORAGE_BUFFER,
    }
}

/// Counts the descriptors of a plan, by their type.
pub fn pool_sizes(plan: &Plan) -> [vk::DescriptorPoolSize; 2] {
    let storage = plan.stages().map(|stage| stage.bindings().len() - 1).sum::<usize>();
    let size = |ty, len: usize| vk::DescriptorPoolSize { ty, descriptor_count: len as u32 };
    [
        size(vk::DescriptorType::UNIFORM_BUFFER, set_len(plan) as usize),
        size(vk::DescriptorType::STORAGE_BUFFER, storage * plan.chunks().len()),
    ]
}

/// Counts the descriptor sets of a plan: one a stage and chunk.
pub fn set_len(plan: &Plan) -> u32 {
    (plan.stages().len() * plan.chunks().len()) as u32
}
