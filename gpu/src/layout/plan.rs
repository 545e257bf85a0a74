//! A batch that has been checked, and cut where a binding or a dispatch would be too large.

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

/// So many words are [`ALIGNMENT`] bytes.
const ALIGNED: usize = ALIGNMENT as usize / 4;

/// Instances that are bound and dispatched together: all of a batch, where the device's limits allow
/// it.
#[derive(Clone, Debug)]
pub struct Chunk {
    /// Which of the batch.
    pub instances: Range<usize>,
    pub(super) spans: Spans,
    pub(super) params: Vec<Param>,
}

impl Chunk {
    /// Returns what of a resource's buffer is read or written; `None` if nothing is.
    pub fn span(&self, resource: Resource) -> Option<Span> {
        self.spans[resource as usize]
    }

    /// Returns what is bound for a resource: itself or, as a binding must be filled in any case,
    /// [`Resource::Blob`] in place of what a stage would read and the batch does not have: of
    /// [`Resource::Host`] where the host brings nothing, of [`Resource::Scratch`] where no stage writes
    /// to it.
    pub fn bound(&self, resource: Resource) -> (Resource, Option<Span>) {
        let resource = if self.span(resource).is_some() { resource } else { Resource::Blob };
        (resource, self.span(resource))
    }

    /// Lists the members of its block in [`Resource::Params`], in the order in which they lie in it.
    pub fn params(&self) -> &[Param] {
        &self.params
    }
}

/// How a batch is evaluated on a device.
#[derive(Clone, Debug)]
pub struct Plan {
    instance_len: usize,
    /// With the workgroups of one instance.
    stages: Vec<(Stage, u32)>,
    chunks: Vec<Chunk>,
}

impl Plan {
    /// Checks a batch of a model's envelope against itself and a device, and cuts it.
    ///
    /// # Errors
    /// - [`LayoutError::Device`], [`LayoutError::OffsetAlignment`]: the device cannot run the shaders.
    /// - [`LayoutError::OtherFile`]: envelope or skin are not the model's.
    /// - [`LayoutError::OtherEnvelope`]: the skin follows another envelope, or none.
    /// - [`LayoutError::NoInstances`]
    /// - [`LayoutError::NoOutput`]
    /// - [`LayoutError::VertexRange`], [`LayoutError::NoTangents`], [`LayoutError::Stride`],
    ///   [`LayoutError::Fours`]: the batch asks for what the model does not have, or for arrays that
    ///   overlap themselves or cannot be read.
    /// - [`LayoutError::Binding`], [`LayoutError::Workgroups`]: the model, or one instance, is too large
    ///   for the device.
    pub fn new(
        model: &Model<impl AsRef<[u8]>>,
        envelope: &Envelope<'_>,
        batch: &Batch,
        limits: &DeviceLimits,
    ) -> Result<Self, LayoutError> {
        limits.check()?;
        Self::cut(&envelope::demand(model, envelope, batch)?, limits)
    }

    /// Checks a batch of a model's kernel against itself and a device, and cuts it.
    ///
    /// # Errors
    /// - [`LayoutError::Device`], [`LayoutError::OffsetAlignment`]: the device cannot run the shaders.
    /// - [`LayoutError::OtherFile`]: the kernel is not the model's.
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

    /// Checks a batch of the shapes of a model's skin against itself and a device, and cuts it.
    ///
    /// # Errors
    /// - [`LayoutError::Device`], [`LayoutError::OffsetAlignment`]: the device cannot run the shaders.
    /// - [`LayoutError::OtherFile`]: the skin is not the model's.
    /// - [`LayoutError::NoInstances`]
    /// - [`LayoutError::NoOutput`]
    /// - [`LayoutError::VertexRange`], [`LayoutError::NoTangents`], [`LayoutError::Stride`]: the batch asks
    ///   for what the skin does not have, or for arrays that overlap themselves.
    /// - [`LayoutError::Binding`], [`LayoutError::Workgroups`]: the model, or one instance, is too large for
    ///   the device.
    pub fn of_shapes(
        model: &Model<impl AsRef<[u8]>>,
        skin: &Skin<'_>,
        batch: &ShapesBatch,
        limits: &DeviceLimits,
    ) -> Result<Self, LayoutError> {
        limits.check()?;
        Self::cut(&shapes::demand(model, skin, batch)?, limits)
    }

    /// Checks a batch of a model's filter against itself and a device, and cuts it.
    ///
    /// # Errors
    /// - [`LayoutError::Device`], [`LayoutError::OffsetAlignment`]: the device cannot run the shaders.
    /// - [`LayoutError::OtherFile`]: the filter is not the model's.
    /// - [`LayoutError::NoInstances`]
    /// - [`LayoutError::Samples`]: signals are shorter than the filter.
    /// - [`LayoutError::NoLanes`]
    /// - [`LayoutError::Stride`]: outputs overlap themselves.
    /// - [`LayoutError::Binding`], [`LayoutError::Workgroups`]: the model, or one signal, is too large for the
    ///   device.
    pub fn of_filter(
        model: &Model<impl AsRef<[u8]>>,
        filter: &Filter<'_>,
        batch: &FilterBatch,
        limits: &DeviceLimits,
    ) -> Result<Self, LayoutError> {
        limits.check()?;
        Self::cut(&filter::demand(model, filter, batch)?, limits)
    }

    /// Cuts a batch.
    fn cut(demand: &Demand, limits: &DeviceLimits) -> Result<Self, LayoutError> {
        let stages = demand.dispatched(limits)?;
        let instance_len = demand.instance_len;
        let (mut chunks, mut start) = (Vec::new(), 0);
        while start < instance_len {
            // One instance must fit; the most that do are found by halving.
            demand.check_spans(start..start + 1, limits)?;
            let all = instance_len.min(start.saturating_add(limits.workgroups as usize));
            let (mut most, mut beyond) = (start + 1, all + 1);
            while beyond - most > 1 {
                let middle = most + (beyond - most) / 2;
                let fits = demand.check_spans(start..middle, limits).is_ok();
                *(if fits { &mut most } else { &mut beyond }) = middle;
            }
            // Arrays without gaps are then cut where a span may start, so that no two spans meet.
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

    /// Returns how many instances there is room for.
    pub fn instance_len(&self) -> usize {
        self.instance_len
    }

    /// Lists the stages, each after those that it reads from.
    pub fn stages(&self) -> impl ExactSizeIterator<Item = Stage> + '_ {
        self.stages.iter().map(|(stage, _)| *stage)
    }

    /// Lists the chunks.
    pub fn chunks(&self) -> &[Chunk] {
        &self.chunks
    }

    /// Returns the bytes that a resource's buffer must have; 0 if the batch does not need it.
    pub fn bytes(&self, resource: Resource) -> u64 {
        self.range(resource).end
    }

    /// Returns the content of [`Resource::Params`].
    pub fn params(&self) -> Vec<u8> {
        let mut out = vec![0; self.bytes(Resource::Params) as usize];
        for (block, chunk) in out.chunks_mut(ALIGNMENT as usize).zip(&self.chunks) {
            for (word, (_, value)) in block.as_chunks_mut::<4>().0.iter_mut().zip(chunk.params()) {
                *word = value.to_le_bytes();
            }
        }
        out
    }

    /// Checks the buffers that the host gives: each by what tells it from others, and the bytes of it
    /// that are the resource's. A resource that is not needed may have any, or none. Several may share a
    /// buffer, as long as no stage writes one where another lies.
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
            let meets = |(other, same, range): &&(Resource, B, Range<u64>)| {
                let is_written = self.writes(resource) || self.writes(*other);
                is_written && buffer == *same && own.start < range.end && range.start < own.end
            };
            if let Some((first, ..)) = taken.iter().find(meets) {
                return Err(LayoutError::Overlap { first: *first, second: resource });
            }
            taken.push((resource, buffer, own));
        }
        Ok(())
    }

    /// Checks how many instances of the batch, the first ones, are to be evaluated.
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

    /// Returns the workgroups of a stage's dispatch, where the batch's first `instance_len` instances
    /// are evaluated: x, those of one instance, and y, the instances of the chunk. `None` if none of
    /// them is in the chunk, or the stage not in the plan.
    pub fn workgroups(&self, stage: Stage, chunk: &Chunk, instance_len: usize) -> Option<[u32; 2]> {
        let (_, x) = self.stages.iter().find(|(own, _)| *own == stage)?;
        let here = instance_len.min(chunk.instances.end).checked_sub(chunk.instances.start)?;
        let y = u32::try_from(here).ok().filter(|y| *y > 0)?;
        Some([*x, y])
    }

    /// Returns the bytes of a resource's buffer that any chunk takes.
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
