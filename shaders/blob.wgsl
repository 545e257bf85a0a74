// Bindings of every stage: its params, and the model's blob.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> blob: array<u32>;

// Values for "no joint", "no term" and "no array".
const NO_JOINT: u32 = 0xffffu;
const NO_TERM: u32 = 0xffffu;
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

// Word of a number of a vertex. Attributes of vertices are blocks of eight vertices: for each of len numbers a row of
// eight.
fn word_of(first: u32, len: u32, vertex: u32, number: u32) -> u32 {
    return first + 8u * (len * (vertex / 8u) + number) + vertex % 8u;
}

// Three numbers of a vertex, out of len.
fn vertex_vec3(first: u32, len: u32, vertex: u32) -> vec3<f32> {
    let at = word_of(first, len, vertex, 0u);
    return vec3<f32>(blob_float(at), blob_float(at + 8u), blob_float(at + 16u));
}

fn vertex_vec4(first: u32, vertex: u32) -> vec4<f32> {
    return vec4<f32>(vertex_vec3(first, 4u, vertex), blob_float(word_of(first, 4u, vertex, 3u)));
}

// Element index of an array of u16 that starts at a word.
fn blob_half(word: u32, index: u32) -> u32 {
    return (blob[word + index / 2u] >> (16u * (index & 1u))) & 0xffffu;
}
