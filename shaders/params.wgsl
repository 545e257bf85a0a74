// What every stage binds: where everything lies, in words of 4 bytes, and the model.

struct Params {
    // Counts, of the dispatch and of the model.
    instance_len: u32,
    vertex_first: u32,
    vertex_len: u32,
    joint_len: u32,
    proxy_len: u32,
    palette_len: u32,
    influence_len: u32,
    group_len: u32,
    root: u32,
    predictor: u32,
    // Sections, from the blob's start.
    hierarchy: u32,
    rest_positions: u32,
    rest_normals: u32,
    rest_tangents: u32,
    influence_indices: u32,
    influence_weights: u32,
    keys: u32,
    c1: u32,
    c2: u32,
    pose_ranges: u32,
    origins: u32,
    groups: u32,
    corrections: u32,
    // Arrays in the work of an instance.
    relative: u32,
    rotations: u32,
    gradients: u32,
    features: u32,
    certainties: u32,
    scratch: u32,
    scratch_stride: u32,
    // Arrays with one stretch an instance, from the binding's start.
    work_offset: u32,
    work_stride: u32,
    poses_offset: u32,
    poses_stride: u32,
    palettes_offset: u32,
    palettes_stride: u32,
    confidences_offset: u32,
    confidences_stride: u32,
    // Attributes: 0 for none, 1 for out_a, 2 for out_b; then from the binding's start.
    positions_buffer: u32,
    positions_offset: u32,
    positions_stride: u32,
    positions_instance_stride: u32,
    normals_buffer: u32,
    normals_offset: u32,
    normals_stride: u32,
    normals_instance_stride: u32,
    tangents_buffer: u32,
    tangents_offset: u32,
    tangents_stride: u32,
    tangents_instance_stride: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> blob: array<u32>;

const NO_JOINT: u32 = 0xffffu;

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
