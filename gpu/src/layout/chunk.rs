//! What of a batch is bound and dispatched together.

use super::resource::Resource;
use std::ops::Range;

/// A member of the uniform block, u32, and its value.
pub type Param = (&'static str, u32);

/// Bytes of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The first, from where the host's buffer for the resource starts: a multiple of
    /// [`super::ALIGNMENT`].
    pub offset: u64,
    /// How many.
    pub bytes: u64,
}

/// The span of each resource; `None` for those that a batch does not need.
pub(super) type Spans = [Option<Span>; Resource::ALL.len()];

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
