//! Where an attribute of vertices is written.

use super::array::Array;
use super::demand::{Member, array_members};
use super::resource::Resource;

/// Where an attribute is written in [`super::Resource::Out`]: vertex i *of the range* of instance n at
/// `offset + n * instance_stride + i * stride`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attribute {
    /// The first instance's first vertex.
    pub offset: usize,
    /// Floats from a vertex to the next; at least the attribute's own, 3 or 4.
    pub stride: usize,
    /// Floats from an instance to the next.
    pub instance_stride: usize,
}

impl Attribute {
    /// Returns where it lies, as an array with a stretch of words an instance.
    pub(super) fn array(&self) -> Array {
        Array { offset: self.offset, stride: self.instance_stride }
    }
}

/// Returns the members of attributes: of each where it lies, from a vertex to the next, and from an instance to the
/// next.
pub(super) fn attribute_members(
    positions: Option<Attribute>,
    normals: Option<Attribute>,
    tangents: Option<Attribute>,
) -> impl Iterator<Item = (&'static str, Member)> {
    let of_positions = ["positions_offset", "positions_stride", "positions_instance_stride"];
    let of_normals = ["normals_offset", "normals_stride", "normals_instance_stride"];
    let of_tangents = ["tangents_offset", "tangents_stride", "tangents_instance_stride"];
    let all = [(of_positions, positions), (of_normals, normals), (of_tangents, tangents)];
    all.into_iter().flat_map(|([offset, stride, instance_stride], attribute)| {
        let array = attribute.map(|own| own.array());
        let places = [offset, instance_stride];
        let [offset, instance_stride] = array_members(places, Resource::Out, array);
        let stride = (stride, Member::Number(attribute.map_or(0, |own| own.stride)));
        [offset, stride, instance_stride]
    })
}
