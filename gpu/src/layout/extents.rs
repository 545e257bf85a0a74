//! Which bytes of each resource some instances take.

use super::array::Array;
use super::chunk::{Span, Spans};
use super::demand::Demand;
use super::error::LayoutError;
use super::limits::DeviceLimits;
use super::resource::{ALIGNMENT, Resource};
use std::ops::Range;

impl Demand {
    /// Checks that every binding is within the device's largest; 32 bits count its bytes.
    pub(super) fn check_spans(
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
            Resource::Params => {
                Some(Span { offset: chunk as u64 * ALIGNMENT, bytes: self.param_bytes() })
            }
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
        let own = self.arrays.iter().filter(|(own, _, len)| *own == resource && *len > 0);
        let words = own.map(|&(_, Array { offset, stride }, len)| {
            let at = |instance: usize| {
                (instance as u64).saturating_mul(stride as u64).saturating_add(offset as u64)
            };
            // A stride can be 0, or less than what lies at its steps.
            let last = at(instances.end.saturating_sub(1));
            at(instances.start)..last.saturating_add(len as u64)
        });
        words.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end))
    }
}
