// Params of the stages of an envelope and its skin: counts, and places of arrays in words of 4
// bytes.

layout(set = 0, binding = 0, std140) uniform Params {
    // Counts: vertices of the dispatch, vertices of the skin, then counts of the model.
    uint vertex_first;
    uint vertex_len;
    uint mesh_len;
    uint influence_len;
    uint joint_len;
    uint proxy_len;
    uint palette_len;
    uint group_len;
    uint curve_len;
    uint root;
    uint predictor;
    uint helper_kind;
    // Offsets of sections from the blob's start; NONE if the part has no such section.
    uint hierarchy;
    uint rest_positions;
    uint rest_normals;
    uint rest_tangents;
    uint influence_indices;
    uint influence_weights;
    uint tangent_coefficients;
    uint keys;
    uint c1;
    uint c2;
    uint pose_ranges;
    uint origins;
    uint groups;
    uint corrections;
    uint stretch_ranges;
    uint key_stretches;
    uint curve_ranges;
    uint helper_places;
    // Offsets of arrays in an instance's scratch; the last two are offset and stride of the groups'
    // own scratch.
    uint relative;
    uint rotations;
    uint gradients;
    uint turns;
    uint strains;
    uint features;
    uint curve_features;
    uint group_confidences;
    uint group_scratch;
    uint group_stride;
    // Offset of an array from the binding's start, and stride from an instance to the next.
    uint scratch_offset;
    uint scratch_stride;
    uint poses_offset;
    uint poses_stride;
    uint curves_offset;
    uint curves_stride;
    uint palettes_offset;
    uint palettes_stride;
    uint confidences_offset;
    uint confidences_stride;
    // Offset and stride of the host's own arrays; NONE if the host has no such array.
    uint host_remap_offset;
    uint host_remap_stride;
    uint host_positions_offset;
    uint host_positions_stride;
    uint host_normals_offset;
    uint host_normals_stride;
    uint host_tangents_offset;
    uint host_tangents_stride;
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
