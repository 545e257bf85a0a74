// Transforms of joints in the pose, and columns in the scratch.

// Determinant below which a joint counts as hidden.
const HIDDEN: f32 = 1.0e-3;

fn cross3(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return a.yzx * b.zxy - a.zxy * b.yzx;
}

fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn transform_transposed(m: mat3x3<f32>, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot3(m[0], v), dot3(m[1], v), dot3(m[2], v));
}

fn transform_columns_transposed(m: mat3x3<f32>, n: mat3x3<f32>) -> mat3x3<f32> {
    return mat3x3<f32>(
        transform_transposed(m, n[0]),
        transform_transposed(m, n[1]),
        transform_transposed(m, n[2]),
    );
}

// Column c of a joint's transform, which is stored by rows.
fn pose_column(at: u32, c: u32) -> vec3<f32> {
    return vec3<f32>(poses[at + c], poses[at + 4u + c], poses[at + 8u + c]);
}

// The linear part of a joint's transform.
fn linear_part(at: u32) -> mat3x3<f32> {
    return mat3x3<f32>(pose_column(at, 0u), pose_column(at, 1u), pose_column(at, 2u));
}

// Whether a joint is scaled to about 0, along one axis or more, or mirrored.
fn is_hidden(linear: mat3x3<f32>) -> bool {
    return dot3(linear[0], cross3(linear[1], linear[2])) < HIDDEN;
}

// Whether a joint of the envelope stretches.
fn stretches() -> bool {
    return params.stretch_ranges != NONE;
}

fn load(at: u32) -> vec3<f32> {
    return vec3<f32>(scratch[at], scratch[at + 1u], scratch[at + 2u]);
}

fn load_columns(at: u32) -> mat3x3<f32> {
    return mat3x3<f32>(load(at), load(at + 3u), load(at + 6u));
}
