// Params of the stage shapes: counts, and places of arrays in words of 4 bytes.

layout(set = 0, binding = 0, std140) uniform Params {
    // Range of vertices, and the number of the element type of deltas and slopes.
    uint vertex_first;
    uint vertex_len;
    uint element;
    // Offsets of sections from the blob's start; NONE if the part has no such section.
    uint rest_positions;
    uint rest_normals;
    uint rest_tangents;
    uint shapes;
    uint shape_blocks;
    uint shape_entries;
    uint shape_deltas;
    uint shape_slopes;
    // Offset of an array from the binding's start, and stride from an instance to the next.
    uint weights_offset;
    uint weights_stride;
    // Offset of an attribute from the binding's start, stride from a vertex to the next, and stride
    // from an instance to the next; NONE if the attribute is not written.
    uint positions_offset;
    uint positions_stride;
    uint positions_instance_stride;
    uint normals_offset;
    uint normals_stride;
    uint normals_instance_stride;
    uint tangents_offset;
    uint tangents_stride;
    uint tangents_instance_stride;
} params;
