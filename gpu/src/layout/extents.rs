//! Which bytes of each resource some instances take.

use super::batch::{Array, Batch};
use super::chunk::{Span, Spans};
use super::error::LayoutError;
use super::limits::DeviceLimits;
use super::params::PARAM_BYTES;
use super::resource::{ALIGNMENT, Resource};
use sinew_runtime::envelope::ScratchLayout;
use sinew_runtime::{Envelope, Skin};
use std::ops::Range;

/// A batch that has been checked, with what decides how much memory it takes.
pub(super) struct Extents<'a> {
    pub(super) envelope: &'a Envelope<'a>,
    pub(super) skin: Option<Skin<'a>>,
    pub(super) batch: &'a Batch,
    pub(super) scratch: ScratchLayout,
    pub(super) blob_bytes: u64,
}

impl Extents<'_> {
    /// Checks that every binding is within the device's largest; 32 bits count its bytes.
    pub(super) fn check(
        &self,
        instances: Range<usize>,
        limits: &DeviceLimits,
    ) -> Result<(), LayoutError> {
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

    /// Returns what instances, the chunk of that number, take of each resource.
    pub(super) fn spans(&self, instances: Range<usize>, chunk: usize) -> Spans {
        Resource::ALL.map(|resource| match resource {
            Resource::Params => Some(Span { offset: chunk as u64 * ALIGNMENT, bytes: PARAM_BYTES }),
            // Words are read.
            Resource::Blob => {
                Some(Span { offset: 0, bytes: self.blob_bytes.next_multiple_of(4).max(4) })
            }
            _ => self.words(resource, &instances).map(|Range { start, end }| {
                let offset = start.saturating_mul(4) / ALIGNMENT * ALIGNMENT;
                // What cannot be counted is larger than any binding.
                let bytes = end.checked_mul(4).map_or(u64::MAX, |end| end - offset);
                Span { offset, bytes }
            }),
        })
    }

    /// Returns the words of a resource's buffer from the first to the last that instances take; `None`
    /// if they take none.
    fn words(&self, resource: Resource, instances: &Range<usize>) -> Option<Range<u64>> {
        let Self { envelope, batch, .. } = *self;
        let array = |Array { offset, stride }: Array, len: usize| {
            let at = |instance: usize| {
                (instance as u64).saturating_mul(stride as u64).saturating_add(offset as u64)
            };
            // A stride can be 0, or less than what lies at its steps.
            let last = at(instances.end.saturating_sub(1));
            (len > 0).then(|| at(instances.start)..last.saturating_add(len as u64))
        };
        let union = |a: Range<u64>, b: Range<u64>| a.start.min(b.start)..a.end.max(b.end);
        match resource {
            Resource::Params | Resource::Blob => None,
            Resource::Poses => array(batch.poses, 12 * envelope.joint_len()),
            Resource::Scratch => {
                let stride = self.scratch.len;
                array(Array { offset: 0, stride }, stride)
            }
            Resource::Palettes => array(batch.palettes, 12 * envelope.palette_len()),
            Resource::Confidences => array(batch.confidences?, 1),
            Resource::Host => {
                let own = batch.skin.as_ref().filter(|own| !own.vertices.is_empty())?;
                let arrays = own.host(self.skin.map_or(0, |skin| skin.vertex_len())).into_iter();
                arrays.filter_map(|(own, len)| array(own?, len)).reduce(union)
            }
            Resource::Out => {
                let skin = batch.skin.as_ref()?;
                let last = skin.vertices.len().checked_sub(1)?;
                let own = skin.attributes().into_iter().filter_map(|(attribute, len)| {
                    let own = attribute?;
                    let len = last.saturating_mul(own.stride).saturating_add(len);
                    array(Array { offset: own.offset, stride: own.instance_stride }, len)
                });
                own.reduce(union)
            }
        }
    }
}
