//! A batch that has been checked, and cut where a binding or a dispatch would be too large.

use super::params::{PARAM_BYTES, Param, WorkLayout, out, params};
use super::stage::WorkLen;
use super::{ALIGNMENT, Array, Batch, LayoutError, Resource, Skin, Stage, WORKGROUP};
use sinew_runtime::{Envelope, Model};
use std::ops::Range;

/// So many floats are [`ALIGNMENT`] bytes.
const ALIGNED: usize = ALIGNMENT as usize / 4;

/// What a device must allow, and how much it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeviceLimits {
    /// Largest storage binding, in bytes.
    pub storage_binding_bytes: u64,
    /// Storage buffers of a stage.
    pub storage_buffers: u32,
    /// Bytes to a multiple of which a storage or uniform binding must start.
    pub offset_alignment: u32,
    /// Threads of a workgroup.
    pub workgroup_threads: u32,
    /// Workgroups of a dispatch along each of the first two axes.
    pub groups: u32,
}

impl DeviceLimits {
    /// The limits of wgpu's `downlevel_defaults`, which the shaders keep to.
    pub const DOWNLEVEL: Self = Self {
        storage_binding_bytes: 128 << 20,
        storage_buffers: 4,
        offset_alignment: 256,
        workgroup_threads: 256,
        groups: 65_535,
    };

    /// Checks that the shaders can run within these.
    ///
    /// # Errors
    /// - [`LayoutError::Device`]
    /// - [`LayoutError::OffsetAlignment`]
    pub fn check(&self) -> Result<(), LayoutError> {
        let least = |name, least: u64, found: u64| {
            if found < least { Err(LayoutError::Device { name, least, found }) } else { Ok(()) }
        };
        least("number of storage buffers a stage", 4, self.storage_buffers.into())?;
        least("number of threads a workgroup", WORKGROUP.into(), self.workgroup_threads.into())?;
        least("number of workgroups a dispatch", 65_535, self.groups.into())?;
        if u64::from(self.offset_alignment) > ALIGNMENT {
            let (limit, found) = (ALIGNMENT, self.offset_alignment.into());
            return Err(LayoutError::OffsetAlignment { limit, found });
        }
        Ok(())
    }
}

/// Bytes of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The first, from where the host's buffer for the resource starts: a multiple of [`ALIGNMENT`].
    pub offset: u64,
    /// How many.
    pub bytes: u64,
}

/// How a batch is evaluated on a device.
#[derive(Clone, Debug)]
pub struct Plan {
    instance_len: usize,
    stages: Vec<(Stage, WorkLen)>,
    chunks: Vec<Chunk>,
    groups_max: u32,
}

/// Instances that are bound and dispatched together: all of a batch, where bindings allow it.
#[derive(Clone, Debug)]
pub struct Chunk {
    /// Which of the batch.
    pub instances: Range<usize>,
    spans: [Option<Span>; Resource::ALL.len()],
    params: Vec<Param>,
}

impl Plan {
    /// Checks a batch of a model's envelope against itself and a device, and cuts it.
    ///
    /// # Errors
    /// - [`LayoutError::Device`], [`LayoutError::OffsetAlignment`]: the device cannot run the shaders.
    /// - [`LayoutError::NoInstances`]
    /// - [`LayoutError::VertexRange`], [`LayoutError::NoTangents`], [`LayoutError::Stride`],
    ///   [`LayoutError::Fours`]: the batch asks for what the model does not have, or for arrays that
    ///   overlap themselves or cannot be read.
    /// - [`LayoutError::Binding`]: the model, or one instance, is too large for the device.
    pub fn new(
        model: &Model<'_>,
        envelope: &Envelope<'_>,
        batch: &Batch,
        limits: &DeviceLimits,
    ) -> Result<Self, LayoutError> {
        limits.check()?;
        check(envelope, batch)?;
        let extents = Extents { envelope, batch, blob_bytes: model.blob().len() as u64 };
        let stages = stages(envelope, batch);
        let mut plan = Self {
            instance_len: batch.instance_len,
            stages,
            chunks: Vec::new(),
            groups_max: limits.groups,
        };
        let mut start = 0;
        while start < batch.instance_len {
            let fits = |end: usize| {
                extents.check(start..end, limits)?;
                plan.check_threads(end - start, limits)
            };
            // One instance must fit; the most that do are found by halving.
            fits(start + 1)?;
            let (mut most, mut beyond) = (start + 1, batch.instance_len + 1);
            while beyond - most > 1 {
                let middle = most + (beyond - most) / 2;
                *(if fits(middle).is_ok() { &mut most } else { &mut beyond }) = middle;
            }
            // Arrays without gaps are then cut where a span may start, so that no two spans meet.
            if most < batch.instance_len && most - start > ALIGNED {
                most -= (most - start) % ALIGNED;
            }
            let spans = extents.spans(start..most, plan.chunks.len());
            let mut chunk = Chunk { instances: start..most, spans, params: Vec::new() };
            chunk.params = params(model, envelope, batch, &chunk);
            plan.chunks.push(chunk);
            start = most;
        }
        Ok(plan)
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
        let spans = self.chunks.iter().filter_map(|chunk| chunk.span(resource));
        spans.map(|span| span.offset + span.bytes).max().unwrap_or(0)
    }

    /// Returns the content of [`Resource::Params`].
    pub fn params(&self) -> Vec<u8> {
        let mut out = vec![0; self.bytes(Resource::Params) as usize];
        for (block, chunk) in out.chunks_mut(ALIGNMENT as usize).zip(&self.chunks) {
            for (word, (_, value)) in block.as_chunks_mut::<4>().0.iter_mut().zip(&chunk.params) {
                *word = value.to_le_bytes();
            }
        }
        out
    }

    /// Checks the span of a buffer that the host gives for a resource, `None` for none; a resource
    /// that is not needed may have any.
    ///
    /// # Errors
    /// - [`LayoutError::Missing`]
    /// - [`LayoutError::Misaligned`]
    /// - [`LayoutError::TooShort`]
    pub fn check(&self, resource: Resource, given: Option<Span>) -> Result<(), LayoutError> {
        let least = self.bytes(resource);
        if least == 0 {
            return Ok(());
        }
        let Span { offset, bytes } = given.ok_or(LayoutError::Missing { resource })?;
        if offset % ALIGNMENT != 0 {
            return Err(LayoutError::Misaligned { resource, found: offset });
        }
        if bytes < least {
            return Err(LayoutError::TooShort { resource, least, found: bytes });
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

    /// Returns the workgroups of a stage's dispatch, x and y, where the batch's first `instance_len`
    /// instances are evaluated; `None` if none of them is in the chunk, or the stage not in the plan.
    pub fn groups(&self, stage: Stage, chunk: &Chunk, instance_len: usize) -> Option<[u32; 2]> {
        let (_, work) = self.stages.iter().find(|(own, _)| *own == stage)?;
        let here = instance_len.min(chunk.instances.end).checked_sub(chunk.instances.start)?;
        let groups = work.groups(here);
        let y = groups.div_ceil(self.groups_max.into());
        let x = groups.checked_div(y)? + u64::from(groups % y > 0);
        Some([u32::try_from(x).ok()?, u32::try_from(y).ok()?])
    }

    /// Checks that threads and workgroups can be counted in 32 bits, those that round a dispatch up
    /// included.
    fn check_threads(&self, instances: usize, limits: &DeviceLimits) -> Result<(), LayoutError> {
        let limit = u64::from(u32::MAX / WORKGROUP - limits.groups);
        let counts = self.stages.iter().map(|(_, work)| work.groups(instances));
        match counts.max() {
            Some(found) if found > limit => Err(LayoutError::Threads { limit, found }),
            _ => Ok(()),
        }
    }
}

impl Chunk {
    /// Returns what of a resource's buffer is read or written; `None` if nothing is.
    pub fn span(&self, resource: Resource) -> Option<Span> {
        self.spans[resource as usize]
    }

    /// Returns what is bound for a resource: itself, or, as a binding must be filled in any case, the
    /// [`Resource::Work`] in place of an output that has no attribute.
    pub fn bound(&self, resource: Resource) -> (Resource, Option<Span>) {
        let resource = if self.span(resource).is_some() { resource } else { Resource::Work };
        (resource, self.span(resource))
    }

    /// Lists the members of its block in [`Resource::Params`], in the order in which they lie in it.
    pub fn params(&self) -> &[Param] {
        &self.params
    }

    /// Returns where in its binding an array of the batch has this chunk's first instance.
    pub(super) fn offset_of(&self, resource: Resource, offset: usize, stride: usize) -> usize {
        let bound = self.span(resource).map_or(0, |span| span.offset / 4);
        (offset as u64 + self.instances.start as u64 * stride as u64 - bound) as usize
    }
}

/// Lists the stages of a batch with what each does for an instance.
fn stages(envelope: &Envelope<'_>, batch: &Batch) -> Vec<(Stage, WorkLen)> {
    let predictor = envelope.predictor();
    let corrects = predictor.corrects() && envelope.group_len() > 0;
    let vertex_len = batch.skin.as_ref().map_or(0, |skin| skin.vertices.len());
    let writes = |skin: &Skin| skin.attributes().iter().any(|(attribute, _)| attribute.is_some());
    let writes = batch.skin.as_ref().is_some_and(writes);
    let has = |stage: &Stage| match stage {
        Stage::Gradients | Stage::Palette => predictor.reconstructs(),
        Stage::Joints => !predictor.reconstructs(),
        Stage::Features | Stage::Correction => corrects,
        Stage::Confidence => batch.confidences.is_some(),
        Stage::Skin => vertex_len > 0 && writes,
    };
    let used = Stage::ALL.into_iter().filter(has);
    used.map(|stage| (stage, stage.work_len(envelope, vertex_len))).collect()
}

fn check(envelope: &Envelope<'_>, batch: &Batch) -> Result<(), LayoutError> {
    if batch.instance_len == 0 {
        return Err(LayoutError::NoInstances);
    }
    let stride = |resource, least: usize, found: usize| {
        if found < least { Err(LayoutError::Stride { resource, least, found }) } else { Ok(()) }
    };
    stride(Resource::Palettes, 12 * envelope.palette_len(), batch.palettes.stride)?;
    if let Some(array) = batch.confidences {
        stride(Resource::Confidences, 1, array.stride)?;
    }
    let Some(skin) = &batch.skin else { return Ok(()) };
    let Array { offset, stride: palette_stride } = batch.palettes;
    if offset % 4 != 0 || palette_stride % 4 != 0 {
        return Err(LayoutError::Fours { offset, stride: palette_stride });
    }
    let Range { start, end } = skin.vertices;
    let vertex_len = envelope.vertex_len();
    if start > end || end > vertex_len {
        return Err(LayoutError::VertexRange { start, end, vertex_len });
    }
    if skin.tangents.is_some() && !envelope.has_tangents() {
        return Err(LayoutError::NoTangents);
    }
    for (attribute, least) in skin.attributes() {
        if let Some(attribute) = attribute {
            stride(out(attribute.buffer).1, least, attribute.stride)?;
        }
    }
    Ok(())
}

/// Which bytes of each resource some instances take.
struct Extents<'a> {
    envelope: &'a Envelope<'a>,
    batch: &'a Batch,
    blob_bytes: u64,
}

impl Extents<'_> {
    /// Checks that every binding is within the device's largest; 32 bits count its bytes.
    fn check(&self, instances: Range<usize>, limits: &DeviceLimits) -> Result<(), LayoutError> {
        let limit = limits.storage_binding_bytes.min(u32::MAX.into());
        let spans = self.spans(instances, 0);
        for (resource, span) in Resource::ALL.into_iter().zip(spans) {
            match span {
                Some(Span { bytes, .. }) if bytes > limit => {
                    return Err(LayoutError::Binding { resource, limit, found: bytes });
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn spans(&self, instances: Range<usize>, chunk: usize) -> [Option<Span>; 8] {
        Resource::ALL.map(|resource| match resource {
            Resource::Params => Some(Span { offset: chunk as u64 * ALIGNMENT, bytes: PARAM_BYTES }),
            // Words are read.
            Resource::Blob => {
                Some(Span { offset: 0, bytes: self.blob_bytes.next_multiple_of(4).max(4) })
            }
            _ => self.floats(resource, &instances).map(|Range { start, end }| {
                let offset = start.saturating_mul(4) / ALIGNMENT * ALIGNMENT;
                // What cannot be counted is larger than any binding.
                let bytes = end.checked_mul(4).map_or(u64::MAX, |end| end - offset);
                Span { offset, bytes }
            }),
        })
    }

    /// Returns the floats of a resource's buffer from the first to the last that instances take.
    fn floats(&self, resource: Resource, instances: &Range<usize>) -> Option<Range<u64>> {
        let Self { envelope, batch, .. } = *self;
        let array = |Array { offset, stride }: Array, len: usize| {
            let at = |instance: usize| {
                (instance as u64).saturating_mul(stride as u64).saturating_add(offset as u64)
            };
            at(instances.start)..at(instances.end.saturating_sub(1)).saturating_add(len as u64)
        };
        match resource {
            Resource::Params | Resource::Blob => None,
            Resource::Poses => Some(array(batch.poses, 12 * envelope.joint_len())),
            Resource::Work => {
                let stride = WorkLayout::new(envelope).len;
                Some(array(Array { offset: 0, stride }, stride))
            }
            Resource::Palettes => Some(array(batch.palettes, 12 * envelope.palette_len())),
            Resource::Confidences => Some(array(batch.confidences?, 1)),
            Resource::OutA | Resource::OutB => {
                let skin = batch.skin.as_ref()?;
                let last = skin.vertices.len().checked_sub(1)?;
                let own = skin.attributes().into_iter().filter_map(|(attribute, len)| {
                    let attribute = attribute.filter(|own| out(own.buffer).1 == resource)?;
                    let len = last.saturating_mul(attribute.stride).saturating_add(len);
                    let (offset, stride) = (attribute.offset, attribute.instance_stride);
                    Some(array(Array { offset, stride }, len))
                });
                own.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end))
            }
        }
    }
}
