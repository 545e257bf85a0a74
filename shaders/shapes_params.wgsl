// What the stage shapes is told: where everything lies, in words of 4 bytes.

struct Params {
    // Vertices that are written, and what deltas and slopes are: the number of the element.
    vertex_first: u32,
    vertex_len: u32,
    element: u32,
    // Sections, from the blob's start; NONE stands for one that is not there.
    rest_positions: u32,
    rest_normals: u32,
    rest_tangents: u32,
    shapes: u32,
    shape_blocks: u32,
    shape_entries: u32,
    shape_deltas: u32,
    shape_slopes: u32,
    // Arrays from the binding's start: the first instance's, and from an instance to the next.
    weights_offset: u32,
    weights_stride: u32,
    // Attributes, from the binding's start; an offset of NONE stands for what is not written.
    positions_offset: u32,
    positions_stride: u32,
    positions_instance_stride: u32,
    normals_offset: u32,
    normals_stride: u32,
    normals_instance_stride: u32,
    tangents_offset: u32,
    tangents_stride: u32,
    tangents_instance_stride: u32,
}
