// Transforms of joints in the pose, and columns in the scratch.

#include "vector.glsl"

// Determinant below which a joint counts as hidden.
const float HIDDEN = 1.0e-3;

vec3 transform_transposed(mat3 m, vec3 v) {
    return vec3(dot3(m[0], v), dot3(m[1], v), dot3(m[2], v));
}

mat3 transform_columns_transposed(mat3 m, mat3 n) {
    return mat3(
        transform_transposed(m, n[0]),
        transform_transposed(m, n[1]),
        transform_transposed(m, n[2])
    );
}

// Column c of a joint's transform, which is stored by rows.
vec3 pose_column(uint at, uint c) {
    return vec3(poses[at + c], poses[at + 4u + c], poses[at + 8u + c]);
}

// The linear part of a joint's transform.
mat3 linear_part(uint at) {
    return mat3(pose_column(at, 0u), pose_column(at, 1u), pose_column(at, 2u));
}

// Whether a joint is scaled to about 0, along one axis or more, or mirrored.
bool is_hidden(mat3 linear) {
    return dot3(linear[0], cross3(linear[1], linear[2])) < HIDDEN;
}

// Whether a joint of the envelope stretches.
bool stretches() {
    return params.stretch_ranges != NONE;
}

vec3 load(uint at) {
    return vec3(scratch[at], scratch[at + 1u], scratch[at + 2u]);
}

mat3 load_columns(uint at) {
    return mat3(load(at), load(at + 3u), load(at + 6u));
}
