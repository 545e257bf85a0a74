// Params of the stages of an envelope and its skin: counts, and places of arrays in words of 4
// bytes.

struct Params {
    // Counts: vertices of the dispatch, vertices of the skin, then counts of the model.
    vertex_first: u32,
    vertex_len: u32,
    mesh_len: u32,
    influence_len: u32,
    joint_len: u32,
    proxy_len: u32,
    palette_len: u32,
    group_len: u32,
    root: u32,
    predictor: u32,
    // Offsets of sections from the blob's start; NONE if the part has no such section.
    hierarchy: u32,
    rest_positions: u32,
    rest_normals: u32,
    rest_tangents: u32,
    influence_indices: u32,
    influence_weights: u32,
    tangent_coefficients: u32,
    keys: u32,
    c1: u32,
    c2: u32,
    pose_ranges: u32,
    origins: u32,
    groups: u32,
    corrections: u32,
    // Offsets of arrays in an instance's scratch; the last two are offset and stride of the groups'
    // own scratch.
    relative: u32,
    rotations: u32,
    gradients: u32,
    features: u32,
    group_confidences: u32,
    group_scratch: u32,
    group_stride: u32,
    // Offset of an array from the binding's start, and stride from an instance to the next.
    scratch_offset: u32,
    scratch_stride: u32,
    poses_offset: u32,
    poses_stride: u32,
    palettes_offset: u32,
    palettes_stride: u32,
    confidences_offset: u32,
    confidences_stride: u32,
    // Offset and stride of the host's own arrays; NONE if the host has no such array.
    host_remap_offset: u32,
    host_remap_stride: u32,
    host_positions_offset: u32,
    host_positions_stride: u32,
    host_normals_offset: u32,
    host_normals_stride: u32,
    host_tangents_offset: u32,
    host_tangents_stride: u32,
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
