// What every stage binds: where everything lies, in words of 4 bytes, and the model.

struct Params {
    // Counts: vertices of the dispatch and of the skin, then the model's.
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
    // Sections, from the blob's start; NONE stands for one that is not there.
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
    // Arrays in the scratch of an instance; a group's own scratch, and from it to the next group's.
    relative: u32,
    rotations: u32,
    gradients: u32,
    features: u32,
    group_confidences: u32,
    group_scratch: u32,
    group_stride: u32,
    // Arrays from the binding's start: the first instance's, and from an instance to the next.
    scratch_offset: u32,
    scratch_stride: u32,
    poses_offset: u32,
    poses_stride: u32,
    palettes_offset: u32,
    palettes_stride: u32,
    confidences_offset: u32,
    confidences_stride: u32,
    // The same of what the host brings; an offset of NONE stands for what it does not bring.
    host_remap_offset: u32,
    host_remap_stride: u32,
    host_positions_offset: u32,
    host_positions_stride: u32,
    host_normals_offset: u32,
    host_normals_stride: u32,
    host_tangents_offset: u32,
    host_tangents_stride: u32,
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

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> blob: array<u32>;

const NO_JOINT: u32 = 0xffffu;
const NONE: u32 = 0xffffffffu;

fn blob_float(word: u32) -> f32 {
    return bitcast<f32>(blob[word]);
}

fn blob_vec3(word: u32) -> vec3<f32> {
    return vec3<f32>(blob_float(word), blob_float(word + 1u), blob_float(word + 2u));
}

fn blob_vec4(word: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(vec4<u32>(blob[word], blob[word + 1u], blob[word + 2u], blob[word + 3u]));
}

// A u16 of an array of them that starts at a word.
fn blob_half(word: u32, index: u32) -> u32 {
    return (blob[word + index / 2u] >> (16u * (index & 1u))) & 0xffffu;
}
