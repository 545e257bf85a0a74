//! The plan of a batch: checked, and cut into chunks that fit the device.

use super::demand::{Demand, Param, Spans};
use super::envelope::{self, Batch};
use super::error::LayoutError;
use super::filter::{self, FilterBatch};
use super::kernel::{self, KernelBatch};
use super::limits::DeviceLimits;
use super::resource::{ALIGNMENT, Resource, Span};
use super::shapes::{self, ShapesBatch};
use super::stage::Stage;
use sinew_runtime::{Envelope, Filter, KernelMap, Model, Skin};
use std::ops::Range;

/// [`ALIGNMENT`] in words.
const ALIGNED: usize = ALIGNMENT as usize / 4;

/// Instances that are bound and dispatched together. If the device's limits allow, a chunk has all
/// instances of the batch.
#[derive(Clone, Debug)]
pub struct Chunk {
    /// The chunk's instances in the batch.
    pub instances: Range<usize>,
    pub(super) spans: Spans,
    pub(super) params: Vec<Param>,
}

impl Chunk {
    /// Returns the span of a resource's buffer that is read or written; `None` if there is none.
    pub fn span(&self, resource: Resource) -> Option<Span> {
        self.spans[resource as usize]
    }

    /// Returns the resource to bind for a resource, with its span. A binding must not be empty. If
    /// the batch lacks a resource that a stage would only read, [`Resource::Blob`] is bound
    /// instead: for [`Resource::Host`] if the host has no input, for [`Resource::Poses`] and
    /// [`Resource::Curves`] if the envelope has no joints or no curves, and for
    /// [`Resource::Scratch`] if no stage writes to it.
    pub fn bound(&self, resource: Resource) -> (Resource, Option<Span>) {
        let resource = if self.span(resource).is_some() { resource } else { Resource::Blob };
        (resource, self.span(resource))
    }

    /// Lists the members of the chunk's block in [`Resource::Params`], in the block's order.
    pub fn params(&self) -> &[Param] {
        &self.params
    }
}

/// A batch that has been checked and cut for a device.
#[derive(Clone, Debug)]
pub struct Plan {
    instance_len: usize,
    /// Each stage with the workgroups of one instance.
    stages: Vec<(Stage, u32)>,
    chunks: Vec<Chunk>,
}

impl Plan {
    /// Checks a batch of a model's envelope, also against the limits of a device, and cuts the
    /// batch.
    ///
    /// # Errors
    /// - [`LayoutError::Device`], [`LayoutError::OffsetAlignment`]: the device cannot run the
    ///   shaders.
    /// - [`LayoutError::OtherFile`]: the envelope or the skin belongs to another file.
    /// - [`LayoutError::OtherEnvelope`]: the skin follows another envelope, or no envelope.
    /// - [`LayoutError::NoInstances`]
    /// - [`LayoutError::NoOutput`]
    /// - [`LayoutError::VertexRange`], [`LayoutError::NoTangents`], [`LayoutError::Stride`],
    ///   [`LayoutError::Fours`]: the model lacks a vertex or an attribute that the batch needs, or an
    ///   array overlaps itself or is misaligned.
    /// - [`LayoutError::Binding`], [`LayoutError::Workgroups`]: the model, or one instance, is too
    ///   large for the device.
    pub fn new(
        model: &Model<impl AsRef<[u8]>>,
        envelope: &Envelope<'_>,
        batch: &Batch,
        limits: &DeviceLimits,
    ) -> Result<Self, LayoutError> {
        limits.check()?;
        Self::cut(&envelope::demand(model, envelope, batch)?, limits)
    }

    /// Checks a batch of a model's kernel, also against the limits of a device, and cuts the batch.
    ///
    /// # Errors
    /// - [`LayoutError::Device`], [`LayoutError::OffsetAlignment`]: the device cannot run the
    ///   shaders.
    /// - [`LayoutError::OtherFile`]: the kernel belongs to another file.
    /// - [`LayoutError::NoInstances`]
    /// - [`LayoutError::Stride`]: outputs or confidences overlap themselves.
    /// - [`LayoutError::Binding`]: the model, or one instance, is too large for the device.
    pub fn of_kernel(
        model: &Model<impl AsRef<[u8]>>,
        kernel: &KernelMap<'_>,
        batch: &KernelBatch,
        limits: &DeviceLimits,
    ) -> Result<Self, LayoutError> {
        limits.check()?;
        Self::cut(&kernel::demand(model, kernel, batch)?, limits)
    }

    /// Checks a batch of the shapes of a model's skin, also against the limits of a device, and
    /// cuts the batch.
    ///
    /// # Errors
    /// - [`LayoutError::Device`], [`LayoutError::OffsetAlignment`]: the device cannot run the
    ///   shaders.
    /// - [`LayoutError::OtherFile`]: the skin belongs to another file.
    /// - [`LayoutError::NoInstances`]
    /// - [`LayoutError::NoOutput`]
    /// - [`LayoutError::VertexRange`], [`LayoutError::NoTangents`], [`LayoutError::Stride`]: the
    ///   skin lacks a vertex or an attribute that the batch needs, or an array overlaps itself.
    /// - [`LayoutError::Binding`], [`LayoutError::Workgroups`]: the model, or one instance, is too
    ///   large for the device.
    pub fn of_shapes(
        model: &Model<impl AsRef<[u8]>>,
        skin: &Skin<'_>,
        batch: &ShapesBatch,
        limits: &DeviceLimits,
    ) -> Result<Self, LayoutError> {
        limits.check()?;
        Self::cut(&shapes::demand(model, skin, batch)?, limits)
    }

    /// Checks a batch of a model's filter, also against the limits of a device, and cuts the batch.
    ///
    /// # Errors
    /// - [`LayoutError::Device`], [`LayoutError::OffsetAlignment`]: the device cannot run the
    ///   shaders.
    /// - [`LayoutError::OtherFile`]: the filter belongs to another file.
    /// - [`LayoutError::NoInstances`]
    /// - [`LayoutError::Samples`]: signals are shorter than the filter.
    /// - [`LayoutError::NoLanes`]
    /// - [`LayoutError::Stride`]: outputs overlap themselves.
    /// - [`LayoutError::Binding`], [`LayoutError::Workgroups`]: the model, or one signal, is too
    ///   large for the device.
    pub fn of_filter(
        model: &Model<impl AsRef<[u8]>>,
        filter: &Filter<'_>,
        batch: &FilterBatch,
        limits: &DeviceLimits,
    ) -> Result<Self, LayoutError> {
        limits.check()?;
        Self::cut(&filter::demand(model, filter, batch)?, limits)
    }

    /// Cuts a batch into chunks.
    fn cut(demand: &Demand, limits: &DeviceLimits) -> Result<Self, LayoutError> {
        let stages = demand.dispatched(limits)?;
        let instance_len = demand.instance_len;
        let (mut chunks, mut start) = (Vec::new(), 0);
        while start < instance_len {
            // One instance must fit. Bisection finds the largest number of instances that fit.
            demand.check_spans(start..start + 1, limits)?;
            let all = instance_len.min(start.saturating_add(limits.workgroups as usize));
            let (mut most, mut beyond) = (start + 1, all + 1);
            while beyond - most > 1 {
                let middle = most + (beyond - most) / 2;
                let fits = demand.check_spans(start..middle, limits).is_ok();
                *(if fits { &mut most } else { &mut beyond }) = middle;
            }
            // Cut at an aligned offset, so that the spans of arrays without gaps do not overlap.
            if most < instance_len && most - start > ALIGNED {
                most -= (most - start) % ALIGNED;
            }
            let spans = demand.spans(start..most, chunks.len());
            let params = demand.params(start, &spans);
            chunks.push(Chunk { instances: start..most, spans, params });
            start = most;
        }
        Ok(Self { instance_len, stages, chunks })
    }

    /// Returns the number of instances that the batch has room for.
    pub fn instance_len(&self) -> usize {
        self.instance_len
    }

    /// Lists the stages, each after the stages that it reads from.
    pub fn stages(&self) -> impl ExactSizeIterator<Item = Stage> + '_ {
        self.stages.iter().map(|(stage, _)| *stage)
    }

    /// Lists the chunks.
    pub fn chunks(&self) -> &[Chunk] {
        &self.chunks
    }

    /// Returns the bytes that a resource's buffer must have; 0 if the batch does not need the
    /// resource.
    pub fn bytes(&self, resource: Resource) -> u64 {
        self.range(resource).end
    }

    /// Returns the content of [`Resource::Params`].
    pub fn params(&self) -> Vec<u8> {
        let mut out = vec![0; self.bytes(Resource::Params) as usize];
        for chunk in &self.chunks {
            let first = chunk.span(Resource::Params).map_or(0, |span| span.offset as usize);
            let block = out.get_mut(first..).unwrap_or_default().as_chunks_mut::<4>().0;
            for (word, (_, value)) in block.iter_mut().zip(chunk.params()) {
                *word = value.to_le_bytes();
            }
        }
        out
    }

    /// Checks the host's buffers. `given` returns the buffer of a resource, and the resource's span
    /// in the buffer. A resource that is not needed may have any buffer, or none. Several resources
    /// may share a buffer, but no stage may write to one where another lies.
    ///
    /// # Errors
    /// - [`LayoutError::Missing`]
    /// - [`LayoutError::Misaligned`]
    /// - [`LayoutError::TooShort`]
    /// - [`LayoutError::Overlap`]
    pub fn check_buffers<B: PartialEq>(
        &self,
        given: impl Fn(Resource) -> Option<(B, Span)>,
    ) -> Result<(), LayoutError> {
        let mut taken: Vec<(Resource, B, Range<u64>)> = Vec::new();
        for resource in Resource::ALL {
            let Range { start, end: least } = self.range(resource);
            if least == 0 {
                continue;
            }
            let (buffer, span) = given(resource).ok_or(LayoutError::Missing { resource })?;
            let Span { offset, bytes: found } = span;
            if offset % ALIGNMENT != 0 {
                return Err(LayoutError::Misaligned { resource, found: offset });
            }
            if found < least {
                return Err(LayoutError::TooShort { resource, least, found });
            }
            let own = offset.saturating_add(start)..offset.saturating_add(least);
            let overlaps = |(other, same, range): &&(Resource, B, Range<u64>)| {
                let is_written = self.writes(resource) || self.writes(*other);
                is_written && buffer == *same && own.start < range.end && range.start < own.end
            };
            if let Some((first, ..)) = taken.iter().find(overlaps) {
                return Err(LayoutError::Overlap { first: *first, second: resource });
            }
            taken.push((resource, buffer, own));
        }
        Ok(())
    }

    /// Checks the number of instances to evaluate, the first ones of the batch.
    ///
    /// # Errors
    /// - [`LayoutError::NoInstances`]
    /// - [`LayoutError::TooManyInstances`]
    pub fn check_instances(&self, found: usize) -> Result<(), LayoutError> {
        match found {
            0 => Err(LayoutError::NoInstances),
            _ if found > self.instance_len => {
                Err(LayoutError::TooManyInstances { expected: self.instance_len, found })
            }
            _ => Ok(()),
        }
    }

    /// Returns the workgroups of a stage's dispatch for the first `instance_len` instances of the
    /// batch. x counts the workgroups of one instance, y the instances of the chunk. `None` if none
    /// of the instances is in the chunk, or if the plan lacks the stage.
    pub fn workgroups(&self, stage: Stage, chunk: &Chunk, instance_len: usize) -> Option<[u32; 2]> {
        let (_, x) = self.stages.iter().find(|(own, _)| *own == stage)?;
        let here = instance_len.min(chunk.instances.end).checked_sub(chunk.instances.start)?;
        let y = u32::try_from(here).ok().filter(|y| *y > 0)?;
        Some([*x, y])
    }

    /// Returns the range of bytes of a resource's buffer that the chunks use.
    fn range(&self, resource: Resource) -> Range<u64> {
        let spans = self.chunks.iter().filter_map(|chunk| chunk.span(resource));
        let ranges = spans.map(|span| span.offset..span.offset + span.bytes);
        ranges.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)).unwrap_or(0..0)
    }

    fn writes(&self, resource: Resource) -> bool {
        let mut bindings = self.stages().flat_map(Stage::bindings);
        bindings.any(|own| own.resource == resource && own.writable)
    }
}
