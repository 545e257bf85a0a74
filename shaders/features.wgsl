// Stage features: the rotation and the translation of each joint relative to its parent, and the
// curves. One thread a joint and a curve.

@group(0) @binding(2) var<storage, read> poses: array<f32>;
@group(0) @binding(3) var<storage, read> curves: array<f32>;
@group(0) @binding(4) var<storage, read_write> scratch: array<f32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let instance = workgroup.y;
    let joint = 64u * workgroup.x + thread;
    let curve = joint;
    let base = params.scratch_offset + instance * params.scratch_stride;
    if curve < params.curve_len {
        let at = params.curves_offset + instance * params.curves_stride + curve;
        scratch[base + params.curve_features + curve] = curves[at];
    }
    if joint >= params.joint_len {
        return;
    }
    let pose = params.poses_offset + instance * params.poses_stride;
    let out = base + params.features + 12u * joint;
    let parent = blob_half(params.hierarchy, joint);
    let own = pose + 12u * joint;
    let linear = linear_part(own);
    let above = pose + 12u * parent;
    if parent == NO_JOINT || is_hidden(linear) || is_hidden(linear_part(above)) {
        for (var i = 0u; i < 12u; i++) {
            scratch[out + i] = 0.0;
        }
        return;
    }
    let parent_linear = linear_part(above);
    let origin = blob_vec3(params.origins + 3u * joint);
    // The differences come first, so that the rest pose gives exactly 0.
    let x = linear[0] - parent_linear[0];
    let y = linear[1] - parent_linear[1];
    let z = linear[2] - parent_linear[2];
    let apart = pose_column(own, 3u) - pose_column(above, 3u);
    var gap = (x * origin.x + y * origin.y + z * origin.z) + apart;
    var turn = linear;
    var parent_turn = parent_linear;
    if stretches() {
        turn = load_columns(base + params.turns + 9u * joint);
        parent_turn = load_columns(base + params.turns + 9u * parent);
    }
    gap = transform_transposed(parent_turn, gap);
    turn = half_of(transform_columns_transposed(parent_turn, turn));
    for (var i = 0u; i < 9u; i++) {
        scratch[out + 4u * (i % 3u) + i / 3u] = turn[i / 3u][i % 3u];
    }
    for (var r = 0u; r < 3u; r++) {
        scratch[out + 4u * r + 3u] = gap[r];
    }
}

// S - I, where S is half of a rotation; the odd part of S fades towards half a turn.
fn half_of(m: mat3x3<f32>) -> mat3x3<f32> {
    let q = quaternion(m);
    let length = sqrt((q.x * q.x + q.y * q.y + q.z * q.z) + q.w * q.w);
    let low = 1.0 - q.w / length;
    let low_4 = (low * low) * (low * low);
    let odd = (1.0 - low_4 * low_4) / length;
    let even = 1.0 / (length * (length + q.w));
    let v = q.xyz * odd;
    let xx = q.x * q.x;
    let yy = q.y * q.y;
    let zz = q.z * q.z;
    let xy = even * (q.x * q.y);
    let xz = even * (q.x * q.z);
    let yz = even * (q.y * q.z);
    return mat3x3<f32>(
        vec3<f32>(-even * (yy + zz), xy + v.z, xz - v.y),
        vec3<f32>(xy - v.z, -even * (xx + zz), yz + v.x),
        vec3<f32>(xz + v.y, yz - v.x, -even * (xx + yy)),
    );
}
