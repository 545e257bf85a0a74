//! A plan bound to the host's buffers.

use super::error::{Error, scoped};
use super::pipelines::{Pipelines, limits, usage};
use crate::layout::{Binding, Chunk, DeviceLimits, LayoutError, Plan, Resource, Span, Stage};
use ::wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, Buffer, BufferBinding,
    CommandEncoder, ComputePass, ComputePassDescriptor, ComputePipeline,
};
use std::num::NonZero;

/// The host's buffers by resource. Resources that the plan does not need may be left out.
#[derive(Clone, Copy, Debug, Default)]
pub struct Buffers<'a>([Option<(&'a Buffer, u64)>; Resource::ALL.len()]);

impl<'a> Buffers<'a> {
    /// Starts without buffers.
    pub fn new() -> Self {
        Self::default()
    }

    /// Assigns a resource a buffer, starting at byte `offset`, a multiple of
    /// [`crate::layout::ALIGNMENT`].
    #[must_use]
    pub fn with(mut self, resource: Resource, buffer: &'a Buffer, offset: u64) -> Self {
        self.0[resource as usize] = Some((buffer, offset));
        self
    }

    fn get(&self, resource: Resource) -> Option<(&'a Buffer, u64)> {
        self.0[resource as usize]
    }

    /// Returns a resource's buffer and its bytes from the offset to the end.
    fn span(&self, resource: Resource) -> Option<(&'a Buffer, Span)> {
        let (buffer, offset) = self.get(resource)?;
        Some((buffer, Span { offset, bytes: buffer.size().saturating_sub(offset) }))
    }
}

/// A plan bound to buffers, ready to be recorded each frame.
#[derive(Clone, Debug)]
pub struct Bound {
    plan: Plan,
    stages: Vec<BoundStage>,
}

#[derive(Clone, Debug)]
struct BoundStage {
    stage: Stage,
    pipeline: ComputePipeline,
    /// One bind group for each chunk of the plan.
    bind_groups: Vec<BindGroup>,
}

impl Bound {
    /// Checks the host's buffers and binds them. Repeat this only when a buffer or the batch
    /// changes. The bind groups keep the buffers alive.
    ///
    /// This function cannot detect a buffer that is destroyed or mapped when commands are
    /// submitted; wgpu reports it then. It cannot detect a buffer of another instance either; wgpu
    /// panics.
    ///
    /// # Errors
    /// - [`Error::Layout`]: a buffer is missing, too short or misaligned; a resource that is
    ///   written overlaps another; or the plan was made for a device with larger limits.
    /// - [`Error::Usage`]
    /// - [`Error::Shared`]
    /// - [`Error::NoPipeline`]
    /// - [`Error::OutOfMemory`]
    /// - [`Error::Refused`]: the device refuses a buffer, for example one of another device.
    pub fn new(pipelines: &Pipelines, plan: &Plan, buffers: &Buffers<'_>) -> Result<Self, Error> {
        plan.check_buffers(|resource| buffers.span(resource))?;
        check_usages(plan, buffers)?;
        let limits = limits(&pipelines.device.limits());
        for chunk in plan.chunks() {
            check_limits(plan, chunk, &limits)?;
            for stage in plan.stages() {
                check_shared(stage, chunk, buffers)?;
            }
        }
        let stages = plan.stages().map(|stage| BoundStage::new(pipelines, plan, stage, buffers));
        let stages = stages.collect::<Result<_, _>>()?;
        Ok(Self { plan: plan.clone(), stages })
    }

    /// Returns the plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Records all stages for the first `instance_len` instances of the batch, in one compute pass.
    /// Nothing is written for the instances that follow.
    ///
    /// # Errors
    /// Nothing is recorded if an error is returned.
    /// - [`Error::Layout`]: no instances, or more than the batch has room for.
    pub fn encode(&self, encoder: &mut CommandEncoder, instance_len: usize) -> Result<(), Error> {
        self.plan.check_instances(instance_len)?;
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
        for stage in &self.stages {
            stage.record(&self.plan, &mut pass, instance_len);
        }
        Ok(())
    }

    /// Records one stage alone, in a separate compute pass. For hosts that measure, or that insert
    /// their own work between stages.
    ///
    /// # Errors
    /// Nothing is recorded if an error is returned.
    /// - [`Error::NotPlanned`]
    /// - [`Error::Layout`]: no instances, or more than the batch has room for.
    pub fn encode_stage(
        &self,
        encoder: &mut CommandEncoder,
        stage: Stage,
        instance_len: usize,
    ) -> Result<(), Error> {
        let own = self.stages.iter().find(|own| own.stage == stage);
        let own = own.ok_or(Error::NotPlanned { stage })?;
        self.plan.check_instances(instance_len)?;
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
        own.record(&self.plan, &mut pass, instance_len);
        Ok(())
    }
}

impl BoundStage {
    fn new(
        pipelines: &Pipelines,
        plan: &Plan,
        stage: Stage,
        buffers: &Buffers<'_>,
    ) -> Result<Self, Error> {
        let own = pipelines.get(stage)?;
        let entries = plan.chunks().iter().map(|chunk| entries(stage, chunk, buffers));
        let entries = entries.collect::<Result<Vec<_>, _>>()?;
        let bind_groups = scoped(&pipelines.device, "bind groups", || {
            let make = |entries: &Vec<_>| {
                let label = Some(stage.name());
                let layout = &own.layout;
                pipelines.device.create_bind_group(&BindGroupDescriptor { label, layout, entries })
            };
            entries.iter().map(make).collect()
        })?;
        Ok(Self { stage, pipeline: own.pipeline.clone(), bind_groups })
    }

    fn record(&self, plan: &Plan, pass: &mut ComputePass<'_>, instance_len: usize) {
        pass.set_pipeline(&self.pipeline);
        for (chunk, bind_group) in plan.chunks().iter().zip(&self.bind_groups) {
            if let Some([x, y]) = plan.workgroups(self.stage, chunk, instance_len) {
                pass.set_bind_group(0, bind_group, &[]);
                pass.dispatch_workgroups(x, y, 1);
            }
        }
    }
}

/// Checks that each buffer has the usage of its resource.
fn check_usages(plan: &Plan, buffers: &Buffers<'_>) -> Result<(), Error> {
    for resource in Resource::ALL {
        let expected = usage(resource);
        match buffers.get(resource) {
            Some((own, _)) if plan.bytes(resource) > 0 && !own.usage().contains(expected) => {
                return Err(Error::Usage { resource, expected, found: own.usage() });
            }
            _ => {}
        }
    }
    Ok(())
}

/// Checks that a chunk stays within the limits of this device.
fn check_limits(plan: &Plan, chunk: &Chunk, limits: &DeviceLimits) -> Result<(), LayoutError> {
    let limit = limits.storage_binding_bytes;
    for resource in Resource::ALL {
        match chunk.span(resource) {
            Some(Span { bytes: found, .. }) if found > limit => {
                return Err(LayoutError::Binding { resource, limit, found });
            }
            _ => {}
        }
    }
    let all = plan.instance_len();
    let counts = plan.stages().filter_map(|stage| plan.workgroups(stage, chunk, all));
    let least = counts.flatten().max().unwrap_or(0);
    if least > limits.workgroups {
        let (least, found) = (least.into(), limits.workgroups.into());
        return Err(LayoutError::Device { name: "number of workgroups a dispatch", least, found });
    }
    Ok(())
}

/// Checks that a stage reads no buffer that it writes: wgpu tracks uses of whole buffers.
fn check_shared(stage: Stage, chunk: &Chunk, buffers: &Buffers<'_>) -> Result<(), Error> {
    let bound = |own: &Binding| {
        let (resource, _) = chunk.bound(own.resource);
        Some((resource, own.writable, buffers.get(resource)?.0))
    };
    let bound = || stage.bindings().iter().filter_map(bound);
    for (written, _, buffer) in bound().filter(|(_, writes, _)| *writes) {
        let mut read = bound().filter(|(_, writes, other)| !writes && *other == buffer);
        if let Some((read, ..)) = read.next() {
            return Err(Error::Shared { stage, written, read });
        }
    }
    Ok(())
}

/// Lists the entries of a stage's bind group for a chunk.
fn entries<'a>(
    stage: Stage,
    chunk: &Chunk,
    buffers: &Buffers<'a>,
) -> Result<Vec<BindGroupEntry<'a>>, Error> {
    let entry = |resource: Resource, binding: u32| {
        let (resource, span) = chunk.bound(resource);
        let (Some(span), Some((buffer, offset))) = (span, buffers.get(resource)) else {
            return Err(LayoutError::Missing { resource }.into());
        };
        let (offset, size) = (offset + span.offset, NonZero::new(span.bytes));
        Ok(BindGroupEntry {
            binding,
            resource: BindingResource::Buffer(BufferBinding { buffer, offset, size }),
        })
    };
    stage.bindings().iter().zip(0..).map(|(own, binding)| entry(own.resource, binding)).collect()
}
