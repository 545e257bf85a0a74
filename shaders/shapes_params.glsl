// What the stage shapes is told: where everything lies, in words of 4 bytes.

layout(set = 0, binding = 0, std140) uniform Params {
    // Vertices that are written, and what deltas and slopes are: the number of the element.
    uint vertex_first;
    uint vertex_len;
    uint element;
    // Sections, from the blob's start; NONE stands for one that is not there.
    uint rest_positions;
    uint rest_normals;
    uint rest_tangents;
    uint shapes;
    uint shape_blocks;
    uint shape_entries;
    uint shape_deltas;
    uint shape_slopes;
    // Arrays from the binding's start: the first instance's, and from an instance to the next.
    uint weights_offset;
    uint weights_stride;
    // Attributes, from the binding's start; an offset of NONE stands for what is not written.
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
