//! A plan bound to the host's buffers, ready to be recorded each frame.

use super::error::Error;
use super::pipelines::{Pipelines, descriptor_type};
use crate::layout::{Chunk, Plan, Resource, Span, Stage};
use ash::{Device, vk};

/// The host's buffers, one for each resource of a plan. Several resources may share a buffer, but
/// no stage may write to one where another lies. Two buffers that share memory are not detected.
#[derive(Clone, Copy, Debug, Default)]
pub struct Buffers([Option<(vk::Buffer, Span)>; Resource::ALL.len()]);

impl Buffers {
    /// Assigns a resource `bytes` bytes of a buffer, starting at `offset`, a multiple of
    /// [`crate::layout::ALIGNMENT`].
    #[must_use]
    pub fn with(mut self, resource: Resource, buffer: vk::Buffer, offset: u64, bytes: u64) -> Self {
        self.0[resource as usize] = Some((buffer, Span { offset, bytes }));
        self
    }

    fn get(&self, resource: Resource) -> Option<(vk::Buffer, Span)> {
        self.0[resource as usize].filter(|(buffer, _)| *buffer != vk::Buffer::null())
    }
}

/// A plan with its buffers: pipelines and written descriptor sets.
///
/// This type owns no Vulkan objects. The sets and pipelines must live as long as the plan is
/// recorded.
#[derive(Clone, Debug)]
pub struct Bound {
    plan: Plan,
    steps: Vec<Step>,
    /// For each step one set a chunk.
    sets: Vec<vk::DescriptorSet>,
}

#[derive(Clone, Copy, Debug)]
struct Step {
    stage: Stage,
    pipeline: vk::Pipeline,
    layout: vk::PipelineLayout,
    /// Whether the step must wait for the steps before it.
    waits: bool,
    /// Whether bindings that the step writes overlap from chunk to chunk. Bindings start at
    /// multiples of 256 bytes, so they may overlap although no two chunks write to the same place.
    /// Validation layers compare bindings, and demand a barrier there.
    chunks_overlap: bool,
}

impl Bound {
    /// Checks the host's buffers and writes the descriptor sets, which the host has allocated with
    /// [`Pipelines::set_layouts`]. Nothing is written if an error is returned.
    ///
    /// # Errors
    /// - [`Error::NoPipeline`]: the pipelines lack a stage of the plan.
    /// - [`Error::Sets`]
    /// - [`Error::Layout`]: a buffer is missing, too short or misaligned, or a resource that is
    ///   written overlaps another.
    ///
    /// # Safety
    /// All handles must be valid and belong to this device. Each buffer must be as long as stated,
    /// have memory bound, and have the [`super::usage`] of its resource. The sets must have the
    /// layouts of [`Pipelines::set_layouts`], in that order, and must not be in use.
    pub unsafe fn new(
        device: &Device,
        pipelines: &Pipelines,
        plan: &Plan,
        buffers: &Buffers,
        sets: &[vk::DescriptorSet],
    ) -> Result<Self, Error> {
        let steps = steps(pipelines, plan)?;
        let (expected, found) = (steps.len() * plan.chunks().len(), sets.len());
        if found != expected {
            return Err(Error::Sets { expected, found });
        }
        plan.check_buffers(|resource| buffers.get(resource))?;
        let bound = Self { plan: plan.clone(), steps, sets: sets.to_vec() };
        for (index, step) in bound.steps.iter().enumerate() {
            for (chunk, set) in plan.chunks().iter().zip(bound.sets_of(index)) {
                // SAFETY: as our own caller promises.
                unsafe { write(device, step.stage, chunk, buffers, *set) };
            }
        }
        Ok(bound)
    }

    /// Records all stages for the first `instance_len` instances. A [`barrier`] precedes the first
    /// stage, and each stage that reads a resource which an earlier stage wrote, or writes a
    /// resource which an earlier stage used. Other barriers stand only between chunks whose
    /// bindings overlap. The module's documentation lists the barriers of the host. The last
    /// stage's pipeline and set 0 stay bound to the compute bind point. Allocates nothing.
    ///
    /// Nothing is written for the instances that follow.
    ///
    /// # Errors
    /// [`Error::Layout`]: no instances, or more than the batch has room for. Nothing has been recorded.
    ///
    /// # Safety
    /// The command buffer must belong to the device of [`Bound::new`] and be recording outside a
    /// render pass, and its queues must support compute. The host must place the barriers that the
    /// module's documentation lists.
    pub unsafe fn record(
        &self,
        device: &Device,
        command_buffer: vk::CommandBuffer,
        instance_len: usize,
    ) -> Result<(), Error> {
        self.plan.check_instances(instance_len)?;
        for (index, step) in self.steps.iter().enumerate() {
            // SAFETY: as our own caller promises.
            unsafe {
                // The first step waits for an earlier record, which uses the same scratch.
                if step.waits || index == 0 {
                    barrier(device, command_buffer);
                }
                self.dispatch(device, command_buffer, index, instance_len);
            }
        }
        Ok(())
    }

    /// Records one stage without a barrier before or after it. For hosts that place their own
    /// barriers, with [`barrier`] or finer ones: for example one between the gradients of several
    /// models and their palettes.
    ///
    /// # Errors
    /// - [`Error::Layout`]: no instances, or more than the batch has room for.
    /// - [`Error::NotPlanned`]
    ///
    /// # Safety
    /// As for [`Bound::record`]. The input of the stage must have been made visible to the stage.
    pub unsafe fn record_stage(
        &self,
        device: &Device,
        command_buffer: vk::CommandBuffer,
        stage: Stage,
        instance_len: usize,
    ) -> Result<(), Error> {
        self.plan.check_instances(instance_len)?;
        let index = self.steps.iter().position(|step| step.stage == stage);
        let index = index.ok_or(Error::NotPlanned { stage })?;
        // SAFETY: as our own caller promises.
        unsafe { self.dispatch(device, command_buffer, index, instance_len) };
        Ok(())
    }

    /// Returns the plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    fn sets_of(&self, step: usize) -> &[vk::DescriptorSet] {
        let chunks = self.plan.chunks().len();
        &self.sets[step * chunks..][..chunks]
    }

    /// # Safety
    /// As for [`Bound::record`].
    unsafe fn dispatch(
        &self,
        device: &Device,
        command_buffer: vk::CommandBuffer,
        index: usize,
        instance_len: usize,
    ) {
        const COMPUTE: vk::PipelineBindPoint = vk::PipelineBindPoint::COMPUTE;
        let Step { stage, pipeline, layout, chunks_overlap, .. } = self.steps[index];
        // SAFETY: `new` made pipeline, layout and sets fit each other, and our caller keeps them
        // alive.
        unsafe { device.cmd_bind_pipeline(command_buffer, COMPUTE, pipeline) };
        for (number, (chunk, set)) in self.plan.chunks().iter().zip(self.sets_of(index)).enumerate()
        {
            let Some([x, y]) = self.plan.workgroups(stage, chunk, instance_len) else { continue };
            let sets = [*set];
            // SAFETY: as above; the plan keeps workgroups within the limits of the device.
            unsafe {
                if chunks_overlap && number > 0 {
                    barrier(device, command_buffer);
                }
                device.cmd_bind_descriptor_sets(command_buffer, COMPUTE, layout, 0, &sets, &[]);
                device.cmd_dispatch(command_buffer, x, y, 1);
            }
        }
    }
}

/// Records a barrier: compute shaders after the barrier wait for those before it, and see their
/// writes.
///
/// # Safety
/// The command buffer must belong to the device and be recording outside a render pass, and its
/// queues must support compute.
pub unsafe fn barrier(device: &Device, command_buffer: vk::CommandBuffer) {
    const COMPUTE: vk::PipelineStageFlags = vk::PipelineStageFlags::COMPUTE_SHADER;
    let memory = [vk::MemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::SHADER_WRITE)
        .dst_access_mask(vk::AccessFlags::SHADER_READ | vk::AccessFlags::SHADER_WRITE)];
    let none = vk::DependencyFlags::empty();
    // SAFETY: as our own caller promises.
    unsafe {
        device.cmd_pipeline_barrier(command_buffer, COMPUTE, COMPUTE, none, &memory, &[], &[]);
    }
}

/// Lists the steps to record. A step waits if it reads a resource that was written since the last
/// barrier, or writes a resource that was used since then.
fn steps(pipelines: &Pipelines, plan: &Plan) -> Result<Vec<Step>, Error> {
    let mut steps = Vec::with_capacity(plan.stages().len());
    // Resources that were bound since the last barrier, and whether they were written.
    let mut bound = [None; Resource::ALL.len()];
    for stage in plan.stages() {
        let pipeline = pipelines.get(stage)?;
        let bindings = stage.bindings();
        let uses = || {
            plan.chunks().iter().flat_map(|chunk| {
                bindings.iter().map(|own| (chunk.bound(own.resource).0, own.writable))
            })
        };
        let waits = uses().any(|(resource, writes)| {
            bound[resource as usize].is_some_and(|written| written || writes)
        });
        if waits {
            bound = [None; Resource::ALL.len()];
        }
        for (resource, writes) in uses() {
            let written = &mut bound[resource as usize];
            *written = Some(written.unwrap_or(false) || writes);
        }
        let (layout, pipeline) = (pipeline.layout, pipeline.pipeline);
        let chunks_overlap = chunks_overlap(stage, plan.chunks());
        steps.push(Step { stage, pipeline, layout, waits, chunks_overlap });
    }
    Ok(steps)
}

/// Whether a span that a stage writes in one chunk overlaps the span of the next chunk.
fn chunks_overlap(stage: Stage, chunks: &[Chunk]) -> bool {
    let written = stage.bindings().iter().filter(|own| own.writable);
    let spans = written.flat_map(|own| {
        let span = |chunk: &Chunk| chunk.bound(own.resource).1;
        chunks.iter().zip(chunks.iter().skip(1)).map(move |(a, b)| (span(a), span(b)))
    });
    spans.into_iter().any(|spans| match spans {
        (Some(a), Some(b)) => a.offset < b.offset + b.bytes && b.offset < a.offset + a.bytes,
        _ => false,
    })
}

/// Writes the descriptor set of a stage and a chunk.
///
/// # Safety
/// As for [`Bound::new`].
unsafe fn write(
    device: &Device,
    stage: Stage,
    chunk: &Chunk,
    buffers: &Buffers,
    set: vk::DescriptorSet,
) {
    for (number, binding) in (0..).zip(stage.bindings()) {
        let (resource, span) = chunk.bound(binding.resource);
        let (Some(span), Some((buffer, own))) = (span, buffers.get(resource)) else { continue };
        let info = [vk::DescriptorBufferInfo::default()
            .buffer(buffer)
            .offset(own.offset + span.offset)
            .range(span.bytes)];
        let write = vk::WriteDescriptorSet::default()
            .dst_set(set)
            .dst_binding(number)
            .descriptor_type(descriptor_type(resource))
            .buffer_info(&info);
        // SAFETY: the plan has checked that the buffer holds the span.
        unsafe { device.update_descriptor_sets(&[write], &[]) };
    }
}
