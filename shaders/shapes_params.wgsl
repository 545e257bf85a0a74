// Params of the stage shapes: counts, and places of arrays in words of 4 bytes.

struct Params {
    // Range of vertices, and the number of the element type of deltas and slopes.
    vertex_first: u32,
    vertex_len: u32,
    element: u32,
    // Offsets of sections from the blob's start; NONE if the part has no such section.
    rest_positions: u32,
    rest_normals: u32,
    rest_tangents: u32,
    shapes: u32,
    shape_blocks: u32,
    shape_entries: u32,
    shape_deltas: u32,
    shape_slopes: u32,
    // Offset of an array from the binding's start, and stride from an instance to the next.
    weights_offset: u32,
    weights_stride: u32,
    // Offset of an attribute from the binding's start, stride from a vertex to the next, and stride
    // from an instance to the next; NONE if the attribute is not written.
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
