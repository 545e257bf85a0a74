// What every stage binds: where everything lies, in words of 4 bytes, and the model.

layout(set = 0, binding = 0, std140) uniform Params {
    // Counts: vertices of the dispatch and of the skin, then the model's.
    uint vertex_first;
    uint vertex_len;
    uint mesh_len;
    uint influence_len;
    uint joint_len;
    uint proxy_len;
    uint palette_len;
    uint group_len;
    uint root;
    uint predictor;
    // Sections, from the blob's start; NONE stands for one that is not there.
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
    // Arrays in the scratch of an instance; a group's own scratch, and from it to the next group's.
    uint relative;
    uint rotations;
    uint gradients;
    uint features;
    uint group_confidences;
    uint group_scratch;
    uint group_stride;
    // Arrays from the binding's start: the first instance's, and from an instance to the next.
    uint scratch_offset;
    uint scratch_stride;
    uint poses_offset;
    uint poses_stride;
    uint palettes_offset;
    uint palettes_stride;
    uint confidences_offset;
    uint confidences_stride;
    // The same of what the host brings; an offset of NONE stands for what it does not bring.
    uint host_remap_offset;
    uint host_remap_stride;
    uint host_positions_offset;
    uint host_positions_stride;
    uint host_normals_offset;
    uint host_normals_stride;
    uint host_tangents_offset;
    uint host_tangents_stride;
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

layout(set = 0, binding = 1, std430) readonly buffer Blob {
    uint blob[];
};

const uint NO_JOINT = 0xffffu;
const uint NONE = 0xffffffffu;

float blob_float(uint word) {
    return uintBitsToFloat(blob[word]);
}

vec3 blob_vec3(uint word) {
    return vec3(blob_float(word), blob_float(word + 1u), blob_float(word + 2u));
}

vec4 blob_vec4(uint word) {
    return uintBitsToFloat(uvec4(blob[word], blob[word + 1u], blob[word + 2u], blob[word + 3u]));
}

// A u16 of an array of them that starts at a word.
uint blob_half(uint word, uint index) {
    return (blob[word + index / 2u] >> (16u * (index & 1u))) & 0xffffu;
}
