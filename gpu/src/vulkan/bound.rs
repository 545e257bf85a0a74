//! A plan with the host's buffers bound, ready to be recorded each frame.

use super::error::Error;
use super::pipelines::{Pipelines, descriptor_type};
use crate::layout::{Chunk, Plan, Resource, Span, Stage};
use ash::{Device, vk};

/// The host's buffers, one for each resource of a plan. Several resources may share one, as long as
/// none is written where another lies; that two buffers share memory cannot be seen here.
#[derive(Clone, Copy, Debug, Default)]
pub struct Buffers([Option<(vk::Buffer, Span)>; Resource::ALL.len()]);

impl Buffers {
    /// Gives a resource the bytes of a buffer from `offset` on, a multiple of
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

/// A plan with its buffers: pipelines, and descriptor sets that have been written.
///
/// It owns nothing of Vulkan: sets and pipelines must live as long as it is recorded.
#[derive(Clone, Debug)]
pub struct Bound {
    plan: Plan,
    steps: Vec<Step>,
    /// For each step, one a chunk.
    sets: Vec<vk::DescriptorSet>,
}

#[derive(Clone, Copy, Debug)]
struct Step {
    stage: Stage,
    pipeline: vk::Pipeline,
    layout: vk::PipelineLayout,
    /// Whether it must wait for the steps before it.
    waits: bool,
    /// Whether its chunks' bindings meet where it writes: they start at multiples of 256 bytes,
    /// though no two chunks write to one place. Tools that reckon with bindings want a barrier there.
    meets: bool,
}

impl Bound {
    /// Checks the host's buffers and writes the descriptor sets, allocated by the host with
    /// [`Pipelines::set_layouts`]. Where an error is returned, nothing has been written.
    ///
    /// # Errors
    /// - [`Error::NoPipeline`]: a stage of the plan was not among those of the pipelines.
    /// - [`Error::Sets`]
    /// - [`Error::Layout`]: a buffer is missing, too short or misaligned, or a stage writes where
    ///   another resource lies.
    ///
    /// # Safety
    /// Everything must be valid and of this device; each buffer must be as long as said, have memory
    /// bound and the [`super::usage`] of its resource; the sets must have the layouts of
    /// [`Pipelines::set_layouts`], in its order, and not be in use.
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

    /// Records all stages for the first `instance_len` instances, with a [`barrier`] before the first
    /// and wherever one reads what another writes, and nowhere else. The module says what must be visible before, and
    /// what is to be waited for after. The last stage's pipeline and set 0 are left bound to the
    /// compute bind point. Allocates nothing.
    ///
    /// Nothing is written for the instances that follow.
    ///
    /// # Errors
    /// [`Error::Layout`]: no instances, or more than there is room for. Nothing has been recorded.
    ///
    /// # Safety
    /// The command buffer must be of the device of [`Bound::new`], be recording outside a render
    /// pass, and its queues must support compute. The host places the barriers that the module asks for.
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
                // The first waits for a record before: both use the same scratch.
                if step.waits || index == 0 {
                    barrier(device, command_buffer);
                }
                self.dispatch(device, command_buffer, index, instance_len);
            }
        }
        Ok(())
    }

    /// Records one stage with no barrier before or after it: for hosts that place their own, as
    /// between the gradients of several models and their palettes, with [`barrier`] or finer.
    ///
    /// # Errors
    /// - [`Error::Layout`]: no instances, or more than there is room for.
    /// - [`Error::NotPlanned`]
    ///
    /// # Safety
    /// As for [`Bound::record`]; what the stage reads must have been made visible to it.
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

    /// Returns the plan that it was made of.
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
        let Step { stage, pipeline, layout, meets, .. } = self.steps[index];
        // SAFETY: pipeline, layout and sets suit each other by `new`, and our caller keeps them alive.
        unsafe { device.cmd_bind_pipeline(command_buffer, COMPUTE, pipeline) };
        for (number, (chunk, set)) in self.plan.chunks().iter().zip(self.sets_of(index)).enumerate()
        {
            let Some([x, y]) = self.plan.workgroups(stage, chunk, instance_len) else { continue };
            let sets = [*set];
            // SAFETY: likewise; the plan keeps workgroups within the limits it was made with.
            unsafe {
                if meets && number > 0 {
                    barrier(device, command_buffer);
                }
                device.cmd_bind_descriptor_sets(command_buffer, COMPUTE, layout, 0, &sets, &[]);
                device.cmd_dispatch(command_buffer, x, y, 1);
            }
        }
    }
}

/// Records that compute shaders after this wait for those before it, and see what they have written.
///
/// # Safety
/// The command buffer must be of the device, be recording outside a render pass, and its queues must
/// support compute.
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

/// Lists what is recorded. A stage waits for those before it where it reads what one of them writes, or
/// writes what one of them uses, since the last barrier.
fn steps(pipelines: &Pipelines, plan: &Plan) -> Result<Vec<Step>, Error> {
    let mut steps = Vec::with_capacity(plan.stages().len());
    // What has been bound since the last barrier, and whether it was written.
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
        let meets = meets(stage, plan.chunks());
        steps.push(Step { stage, pipeline, layout, waits, meets });
    }
    Ok(steps)
}

/// Tells whether what a stage writes in one chunk is bound in the next, too.
fn meets(stage: Stage, chunks: &[Chunk]) -> bool {
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

/// Writes the set of a stage and chunk.
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
        // SAFETY: the buffer holds the span, which the plan has checked.
        unsafe { device.update_descriptor_sets(&[write], &[]) };
    }
}
