//! The requirements of a batch, whatever its part: stages, arrays and params. A plan cuts them into
//! chunks.

use super::error::LayoutError;
use super::limits::DeviceLimits;
use super::resource::{ALIGNMENT, Array, Attribute, Resource, Span};
use super::stage::{Stage, WORKGROUP};
use sinew_runtime::format::{FileId, PartKind, SectionKind};
use sinew_runtime::{Model, Skin};
use std::ops::Range;

/// A member of the uniform block, by its name, and its value (u32).
pub type Param = (&'static str, u32);

/// The span of each resource; `None` if the batch does not need the resource.
pub(super) type Spans = [Option<Span>; Resource::ALL.len()];

/// Positions, normals and tangents; `None` if the batch does not write the attribute.
pub(super) type Attributes = [Option<Attribute>; 3];

/// Floats of a position, a normal and a tangent.
const FLOATS: [usize; 3] = [3, 3, 4];

/// Offset of an array or a section that does not exist.
pub(super) const NONE: usize = u32::MAX as usize;

/// The requirements of a batch that has been checked.
pub(super) struct Demand {
    /// Number of instances that the buffers have room for.
    pub(super) instance_len: usize,
    /// Stages with the workgroups of one instance, each after the stages that it reads from.
    pub(super) stages: Vec<(Stage, u64)>,
    /// Arrays, each with its resource and the words of one instance.
    pub(super) arrays: Vec<(Resource, Array, usize)>,
    /// Members of the uniform block, in the block's order.
    pub(super) members: Vec<(&'static str, Member)>,
    /// Bytes of the model's blob.
    pub(super) blob_bytes: u64,
}

/// Value of a member of the uniform block.
#[derive(Clone, Copy)]
pub(super) enum Member {
    /// A number that is equal in all chunks.
    Number(usize),
    /// Offset of a chunk's first instance in the binding of an array; [`NONE`] if the batch has no
    /// such array.
    Offset(Resource, Option<Array>),
}

impl Demand {
    /// Lists the stages that have work, each with the workgroups of one instance.
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

    /// Checks that no binding exceeds the device's largest binding, or 2^32 - 1 bytes.
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

    /// Returns the span that a range of instances takes of each resource. The range is the chunk of
    /// number `chunk`.
    pub(super) fn spans(&self, instances: Range<usize>, chunk: usize) -> Spans {
        Resource::ALL.map(|resource| match resource {
            Resource::Params => {
                let bytes = self.param_bytes();
                Some(Span { offset: chunk as u64 * bytes.next_multiple_of(ALIGNMENT), bytes })
            }
            // Shaders read whole words.
            Resource::Blob => {
                Some(Span { offset: 0, bytes: self.blob_bytes.next_multiple_of(4).max(4) })
            }
            _ => self.words(resource, &instances).map(|Range { start, end }| {
                let offset = start.saturating_mul(4) / ALIGNMENT * ALIGNMENT;
                // A length that overflows exceeds any binding.
                let bytes = end.checked_mul(4).map_or(u64::MAX, |end| end - offset);
                Span { offset, bytes }
            }),
        })
    }

    /// Returns the words of a resource's buffer that a range of instances takes, from the first to
    /// the last; `None` if they take none.
    fn words(&self, resource: Resource, instances: &Range<usize>) -> Option<Range<u64>> {
        let own = self.arrays.iter().filter(|(own, _, len)| *own == resource && *len > 0);
        let words = own.map(|&(_, Array { offset, stride }, len)| {
            let at = |instance: usize| {
                (instance as u64).saturating_mul(stride as u64).saturating_add(offset as u64)
            };
            // A stride can be 0, or shorter than the words of an instance.
            let last = at(instances.end.saturating_sub(1));
            at(instances.start)..last.saturating_add(len as u64)
        });
        words.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end))
    }

    /// Returns the size of the uniform block in bytes: its members, padded to a multiple of 16.
    fn param_bytes(&self) -> u64 {
        (4 * self.members.len() as u64).next_multiple_of(16)
    }

    /// Lists the members of a chunk's uniform block, in the block's order.
    ///
    /// - `first`: the chunk's first instance.
    pub(super) fn params(&self, first: usize, spans: &Spans) -> Vec<Param> {
        let value = |member: Member| match member {
            Member::Number(number) => number,
            Member::Offset(resource, array) => {
                let (Some(Array { offset, stride }), Some(span)) =
                    (array, spans[resource as usize])
                else {
                    return NONE;
                };
                let at = (first as u64).saturating_mul(stride as u64).saturating_add(offset as u64);
                at.saturating_sub(span.offset / 4) as usize
            }
        };
        let members = self.members.iter();
        // Offsets within a binding have 30 bits. If a stride has more than 32 bits, each chunk has
        // one instance, and shaders multiply the stride by 0.
        let narrow = |value: usize| u32::try_from(value).unwrap_or(u32::MAX);
        members.map(|&(name, member)| (name, narrow(value(member)))).collect()
    }
}

/// Counts the workgroups for `len` threads.
pub(super) fn threads(len: usize) -> u64 {
    (len as u64).div_ceil(WORKGROUP.into())
}

/// Returns the two members of each array: its offset and its stride.
pub(super) fn array_members<const N: usize>(
    arrays: [([&'static str; 2], Resource, Option<Array>); N],
) -> impl Iterator<Item = (&'static str, Member)> {
    arrays.into_iter().flat_map(|([offset, stride], resource, array)| {
        let own = array.map_or(0, |array| array.stride);
        [(offset, Member::Offset(resource, array)), (stride, Member::Number(own))]
    })
}

/// Lays the attributes of a skin out without gaps: the V positions of an instance, its V normals and, if the skin has
/// tangents, its V tangents; then the next instance.
pub(super) fn packed_attributes(skin: &Skin<'_>) -> Attributes {
    let vertex_len = skin.vertex_len();
    let floats = if skin.has_tangents() { 10 } else { 6 };
    let attribute = |before: usize, stride| {
        let (offset, instance_stride) = (before * vertex_len, floats * vertex_len);
        Some(Attribute { offset, stride, instance_stride })
    };
    [attribute(0, 3), attribute(3, 3), attribute(6, 4).filter(|_| skin.has_tangents())]
}

/// Lists the arrays of attributes of `vertex_len` vertices, with the words of one instance.
pub(super) fn attribute_arrays(
    attributes: Attributes,
    vertex_len: usize,
) -> impl Iterator<Item = (Resource, Array, usize)> {
    attributes.into_iter().zip(FLOATS).filter_map(move |(attribute, len)| {
        let (own, last) = (attribute?, vertex_len.checked_sub(1)?);
        let len = last.saturating_mul(own.stride).saturating_add(len);
        Some((Resource::Out, own.array(), len))
    })
}

/// Checks that a part belongs to the model's file, and that there are instances.
///
/// # Errors
/// [`LayoutError::OtherFile`], [`LayoutError::NoInstances`]
pub(super) fn check_part(
    model: &Model<impl AsRef<[u8]>>,
    (part, file): (PartKind, FileId),
    instance_len: usize,
) -> Result<(), LayoutError> {
    if file != model.id() {
        return Err(LayoutError::OtherFile { part });
    }
    if instance_len == 0 { Err(LayoutError::NoInstances) } else { Ok(()) }
}

/// Checks the attributes that a batch writes for a range of vertices: there are some, and no
/// attribute of a vertex reaches into the next vertex.
///
/// - `is_within`: whether the mesh of `vertex_len` vertices has the range.
/// - `has_tangents`: whether the rest mesh has tangents.
///
/// # Errors
/// [`LayoutError::NoOutput`], [`LayoutError::VertexRange`], [`LayoutError::NoTangents`],
/// [`LayoutError::Stride`]
pub(super) fn check_attributes(
    attributes: Attributes,
    Range { start, end }: Range<usize>,
    vertex_len: usize,
    is_within: bool,
    has_tangents: bool,
) -> Result<(), LayoutError> {
    if attributes.iter().all(Option::is_none) {
        return Err(LayoutError::NoOutput);
    }
    if start > end || !is_within {
        return Err(LayoutError::VertexRange { start, end, vertex_len });
    }
    if attributes[2].is_some() && !has_tangents {
        return Err(LayoutError::NoTangents);
    }
    let written = attributes.into_iter().zip(FLOATS);
    let mut written = written.filter_map(|(own, least)| Some((own?.stride, least)));
    written.try_for_each(|(stride, least)| check_stride(Resource::Out, least, stride))
}

/// Returns the three members of each attribute: its offset, its stride and its instance stride.
pub(super) fn attribute_members(
    [positions, normals, tangents]: Attributes,
) -> impl Iterator<Item = (&'static str, Member)> {
    let of_positions = ["positions_offset", "positions_stride", "positions_instance_stride"];
    let of_normals = ["normals_offset", "normals_stride", "normals_instance_stride"];
    let of_tangents = ["tangents_offset", "tangents_stride", "tangents_instance_stride"];
    let all = [(of_positions, positions), (of_normals, normals), (of_tangents, tangents)];
    all.into_iter().flat_map(|([offset, stride, instance_stride], attribute)| {
        let [own, instance] = attribute.map_or([0; 2], |own| [own.stride, own.instance_stride]);
        [
            (offset, Member::Offset(Resource::Out, attribute.map(|own| own.array()))),
            (stride, Member::Number(own)),
            (instance_stride, Member::Number(instance)),
        ]
    })
}

/// Returns the member of a part's section: its first word in the blob, or [`NONE`] if the part has
/// no such section.
pub(super) fn section_member(
    model: &Model<impl AsRef<[u8]>>,
    part: Option<usize>,
    kind: SectionKind,
) -> (&'static str, Member) {
    let mut rows = model.sections().map(|section| section.row);
    let found = rows.find(|row| Some(usize::from(row.part)) == part && row.kind == kind.number());
    (kind.name(), Member::Number(found.map_or(NONE, |row| row.offset as usize / 4)))
}

/// Checks that a stride is at least as long as the words at each of its steps.
pub(super) fn check_stride(
    resource: Resource,
    least: usize,
    found: usize,
) -> Result<(), LayoutError> {
    if found < least { Err(LayoutError::Stride { resource, least, found }) } else { Ok(()) }
}
