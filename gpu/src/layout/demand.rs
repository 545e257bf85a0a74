//! What a batch asks for, in terms of no part: what a plan is cut of.

use super::array::Array;
use super::error::LayoutError;
use super::limits::DeviceLimits;
use super::resource::Resource;
use super::stage::{Stage, WORKGROUP};
use sinew_runtime::Model;
use sinew_runtime::format::SectionKind;

/// Stands for the offset of an array, or of a section, that is not there.
pub(super) const NONE: usize = u32::MAX as usize;

/// A batch that has been checked.
pub(super) struct Demand {
    /// Instances that there is room for.
    pub(super) instance_len: usize,
    /// Stages, each after those that it reads from, with the workgroups of one instance.
    pub(super) stages: Vec<(Stage, u64)>,
    /// Arrays of resources, with the words of one instance.
    pub(super) arrays: Vec<(Resource, Array, usize)>,
    /// Members of the uniform block, in the order in which they lie in it.
    pub(super) members: Vec<(&'static str, Member)>,
    /// Bytes of the model's blob.
    pub(super) blob_bytes: u64,
}

/// What a member of the uniform block is.
#[derive(Clone, Copy)]
pub(super) enum Member {
    /// A number, the same for all chunks.
    Number(usize),
    /// Where in its binding an array has a chunk's first instance; none if the batch has no such array.
    Offset(Resource, Option<Array>),
}

impl Demand {
    /// Lists the stages that have anything to do, each with its workgroups of an instance.
    ///
    /// # Errors
    /// [`LayoutError::Workgroups`]
    pub(super) fn dispatched(
        &self,
        limits: &DeviceLimits,
    ) -> Result<Vec<(Stage, u32)>, LayoutError> {
        let limit = limits.workgroups;
        let mut stages = Vec::new();
        for &(stage, found) in &self.stages {
            match u32::try_from(found) {
                Ok(0) => {}
                Ok(workgroups) if workgroups <= limit => stages.push((stage, workgroups)),
                _ => return Err(LayoutError::Workgroups { stage, limit: limit.into(), found }),
            }
        }
        Ok(stages)
    }
}

/// Counts the workgroups of so many threads.
pub(super) fn threads(len: usize) -> u64 {
    (len as u64).div_ceil(WORKGROUP.into())
}

/// Returns the members of an array: where it lies, and from an instance to the next.
pub(super) fn array_members(
    [offset, stride]: [&'static str; 2],
    resource: Resource,
    array: Option<Array>,
) -> [(&'static str, Member); 2] {
    let own = array.map_or(0, |array| array.stride);
    [(offset, Member::Offset(resource, array)), (stride, Member::Number(own))]
}

/// Returns the member of a part's section: its first word in the blob; [`NONE`] if there is no such section.
pub(super) fn section_member(
    model: &Model<impl AsRef<[u8]>>,
    part: Option<usize>,
    kind: SectionKind,
) -> (&'static str, Member) {
    let mut rows = model.sections().map(|section| section.row);
    let found = rows.find(|row| Some(usize::from(row.part)) == part && row.kind == kind.number());
    (kind.name(), Member::Number(found.map_or(NONE, |row| row.offset as usize / 4)))
}

/// Checks that what lies at each step of a stride is no longer than that.
pub(super) fn check_stride(
    resource: Resource,
    least: usize,
    found: usize,
) -> Result<(), LayoutError> {
    if found < least { Err(LayoutError::Stride { resource, least, found }) } else { Ok(()) }
}
