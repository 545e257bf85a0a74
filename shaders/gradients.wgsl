// Stage gradients: poses to relative transforms, rotations and the keys' gradients. One workgroup an
// instance.

@group(0) @binding(2) var<storage, read> poses: array<f32>;
@group(0) @binding(3) var<storage, read_write> scratch: array<f32>;

const KEY_WORDS: u32 = 55u;

fn store(at: u32, v: vec3<f32>) {
    scratch[at] = v.x;
    scratch[at + 1u] = v.y;
    scratch[at + 2u] = v.z;
}

fn transform(m: mat3x3<f32>, v: vec3<f32>) -> vec3<f32> {
    return m[0] * v.x + m[1] * v.y + m[2] * v.z;
}

fn transform_columns(m: mat3x3<f32>, n: mat3x3<f32>) -> mat3x3<f32> {
    return mat3x3<f32>(transform(m, n[0]), transform(m, n[1]), transform(m, n[2]));
}

// The transpose of the inverse of the root's linear part; 0 for a hidden root.
fn inverse_transposed(linear: mat3x3<f32>) -> mat3x3<f32> {
    let x = cross3(linear[1], linear[2]);
    let y = cross3(linear[2], linear[0]);
    let z = cross3(linear[0], linear[1]);
    let scale = select(1.0 / dot3(linear[0], x), 0.0, is_hidden(linear));
    return mat3x3<f32>(x * scale, y * scale, z * scale);
}

// The rotation vector of a rotation matrix.
fn log_of(m: mat3x3<f32>) -> vec3<f32> {
    let q = quaternion(m);
    let v = q.xyz;
    let w = q.w;
    let length = sqrt(dot3(v, v));
    if length < 1.0e-18 {
        return vec3<f32>(0.0);
    }
    return v * (2.0 * quadrant_angle(length, w) / length);
}

// The rotation matrix of a rotation vector.
fn exp_of(v: vec3<f32>) -> mat3x3<f32> {
    let square = dot3(v, v);
    var a = 1.0;
    var b = 0.5;
    if square >= 1.0e-8 {
        let angle = sqrt(square);
        let both = sin_versine(angle);
        a = both.x / angle;
        b = both.y / square;
    }
    let xx = v.x * v.x;
    let yy = v.y * v.y;
    let zz = v.z * v.z;
    let xy = b * (v.x * v.y);
    let xz = b * (v.x * v.z);
    let yz = b * (v.y * v.z);
    let turn = a * v;
    return mat3x3<f32>(
        vec3<f32>(1.0 - b * (yy + zz), xy + turn.z, xz - turn.y),
        vec3<f32>(xy - turn.z, 1.0 - b * (xx + zz), yz + turn.x),
        vec3<f32>(xz + turn.y, yz - turn.x, 1.0 - b * (xx + yy)),
    );
}

// The rotation matrix of A theta; A is three rows of the blob.
fn twist(at: u32, theta: vec3<f32>) -> mat3x3<f32> {
    return exp_of(vec3<f32>(
        dot3(blob_vec3(at), theta),
        dot3(blob_vec3(at + 3u), theta),
        dot3(blob_vec3(at + 6u), theta),
    ));
}

// A row of six numbers, times two vectors.
fn row_product(at: u32, a: vec3<f32>, b: vec3<f32>) -> f32 {
    return dot3(blob_vec3(at), a) + dot3(blob_vec3(at + 3u), b);
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let instance = workgroup.y;
    let pose = params.poses_offset + instance * params.poses_stride;
    let base = params.scratch_offset + instance * params.scratch_stride;
    let relative = base + params.relative;
    let rotations = base + params.rotations;

    let root = pose + 12u * params.root;
    var back = linear_part(root);
    let origin = pose_column(root, 3u);
    if stretches() {
        back = inverse_transposed(back);
    }
    for (var joint = thread; joint < params.joint_len; joint += 64u) {
        let at = relative + 12u * joint;
        if joint == params.root {
            store(at, vec3<f32>(1.0, 0.0, 0.0));
            store(at + 3u, vec3<f32>(0.0, 1.0, 0.0));
            store(at + 6u, vec3<f32>(0.0, 0.0, 1.0));
            store(at + 9u, vec3<f32>(0.0));
        } else {
            let own = pose + 12u * joint;
            store(at, transform_transposed(back, pose_column(own, 0u)));
            store(at + 3u, transform_transposed(back, pose_column(own, 1u)));
            store(at + 6u, transform_transposed(back, pose_column(own, 2u)));
            store(at + 9u, transform_transposed(back, pose_column(own, 3u) - origin));
        }
    }
    storageBarrier();

    // Rotations of stage polar, or the linear parts of the relative transforms.
    let turns = select(relative, base + params.turns, stretches());
    let turn_stride = select(12u, 9u, stretches());
    for (var joint = thread; joint < params.joint_len; joint += 64u) {
        let parent = blob_half(params.hierarchy, joint);
        var theta = vec3<f32>(0.0);
        if parent != NO_JOINT {
            let above = load_columns(turns + turn_stride * parent);
            let own = load_columns(turns + turn_stride * joint);
            theta = log_of(transform_columns_transposed(above, own));
        }
        store(rotations + 3u * joint, theta);
    }
    storageBarrier();

    for (var key = thread; key < params.proxy_len; key += 64u) {
        let at = params.keys + KEY_WORDS * key;
        let joint = blob[at] & 0xffffu;
        let residual = blob[at] >> 16u;
        let parent = blob_half(params.hierarchy, joint);
        let b = load(rotations + 3u * joint);
        var p = vec3<f32>(0.0);
        if parent != NO_JOINT {
            p = load(rotations + 3u * parent);
        }
        // Entries xx, xy, xz, yy, yz, zz of S - I.
        var entries: array<f32, 6>;
        for (var i = 0u; i < 6u; i++) {
            entries[i] = row_product(at + 19u + 6u * i, b, p);
            if params.key_stretches != NONE {
                let strain = base + params.strains + 6u * joint;
                let g = params.key_stretches + 36u * key + 6u * i;
                entries[i] += row_product(g, load(strain), load(strain + 3u));
            }
        }
        var out = mat3x3<f32>(
            vec3<f32>(1.0 + entries[0], entries[1], entries[2]),
            vec3<f32>(entries[1], 1.0 + entries[3], entries[4]),
            vec3<f32>(entries[2], entries[4], 1.0 + entries[5]),
        );
        if residual != NO_JOINT {
            out = transform_columns(twist(at + 10u, load(rotations + 3u * residual)), out);
        }
        out = transform_columns(twist(at + 1u, b), out);
        if parent != NO_JOINT {
            var turn = load_columns(turns + turn_stride * parent);
            if stretches() {
                turn = transform_columns_transposed(load_columns(turns + turn_stride * params.root), turn);
            }
            out = transform_columns(turn, out);
        }
        let gradient = base + params.gradients + 9u * key;
        store(gradient, out[0]);
        store(gradient + 3u, out[1]);
        store(gradient + 6u, out[2]);
    }
}
