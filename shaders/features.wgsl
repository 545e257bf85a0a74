// Stage features: the rotation and the translation of each joint relative to its parent. One thread
// a joint.

@group(0) @binding(2) var<storage, read> poses: array<f32>;
@group(0) @binding(3) var<storage, read_write> scratch: array<f32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let instance = workgroup.y;
    let joint = 64u * workgroup.x + thread;
    if joint >= params.joint_len {
        return;
    }
    let pose = params.poses_offset + instance * params.poses_stride;
    let base = params.scratch_offset + instance * params.scratch_stride;
    let out = base + params.features + 12u * joint;
    let parent = blob_half(params.hierarchy, joint);
    if parent == NO_JOINT {
        for (var i = 0u; i < 12u; i++) {
            scratch[out + i] = 0.0;
        }
        return;
    }
    let origin = blob_vec3(params.origins + 3u * joint);
    let above = pose + 12u * parent;
    let own = pose + 12u * joint;
    var rotation: mat3x3<f32>;
    for (var r = 0u; r < 3u; r++) {
        let x = poses[above + r];
        let y = poses[above + 4u + r];
        let z = poses[above + 8u + r];
        var row: vec4<f32>;
        for (var c = 0u; c < 4u; c++) {
            var a = poses[own + c];
            var b = poses[own + 4u + c];
            var d = poses[own + 8u + c];
            if c == 3u {
                // The difference comes first, so that the rest pose gives exactly 0.
                a -= poses[above + 3u];
                b -= poses[above + 7u];
                d -= poses[above + 11u];
            }
            row[c] = x * a + y * b + z * d;
        }
        for (var c = 0u; c < 3u; c++) {
            rotation[c][r] = row[c];
        }
        row[r] -= 1.0;
        scratch[out + 4u * r + 3u] = (row.x * origin.x + row.y * origin.y + row.z * origin.z) + row.w;
    }
    let turn = half_of(rotation);
    for (var i = 0u; i < 9u; i++) {
        scratch[out + 4u * (i % 3u) + i / 3u] = turn[i / 3u][i % 3u];
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
