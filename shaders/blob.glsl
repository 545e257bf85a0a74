// Binding of every stage beside its params: the model's blob.

layout(set = 0, binding = 1, std430) readonly buffer Blob {
    uint blob[];
};

// Values for "no joint", "no term" and "no array".
const uint NO_JOINT = 0xffffu;
const uint NO_TERM = 0xffffu;
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

// Word of number `number` of a vertex. Attributes of vertices are blocks of eight vertices: for each of `len` numbers
// a row of eight.
uint word_of(uint first, uint len, uint vertex, uint number) {
    return first + 8u * (len * (vertex / 8u) + number) + vertex % 8u;
}

// Three numbers of a vertex, out of `len`.
vec3 vertex_vec3(uint first, uint len, uint vertex) {
    uint at = word_of(first, len, vertex, 0u);
    return vec3(blob_float(at), blob_float(at + 8u), blob_float(at + 16u));
}

vec4 vertex_vec4(uint first, uint vertex) {
    return vec4(vertex_vec3(first, 4u, vertex), blob_float(word_of(first, 4u, vertex, 3u)));
}

// Element `index` of an array of u16 that starts at a word.
uint blob_half(uint word, uint index) {
    return (blob[word + index / 2u] >> (16u * (index & 1u))) & 0xffffu;
}
