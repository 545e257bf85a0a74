// The pose features: how each joint has turned and moved against its parent. One thread a joint.

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
                // The difference is taken first, so that rest is exactly 0.
                a -= poses[above + 3u];
                b -= poses[above + 7u];
                d -= poses[above + 11u];
            }
            row[c] = x * a + y * b + z * d;
        }
        row[r] -= 1.0;
        scratch[out + 4u * r] = row.x;
        scratch[out + 4u * r + 1u] = row.y;
        scratch[out + 4u * r + 2u] = row.z;
        scratch[out + 4u * r + 3u] = (row.x * origin.x + row.y * origin.y + row.z * origin.z) + row.w;
    }
}
