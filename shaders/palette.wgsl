// Stage 2: gradients and relative maps to palettes, t = c1 d + c2 q. One thread a row of t, which is
// a column of a map.

@group(0) @binding(2) var<storage, read> poses: array<f32>;
@group(0) @binding(3) var<storage, read> work: array<f32>;
@group(0) @binding(4) var<storage, read_write> palettes: array<f32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let item = (group.y * groups.x + group.x) * 64u + thread;
    let row_len = 4u * params.proxy_len;
    let instance = item / row_len;
    let row = item % row_len;
    if instance >= params.instance_len {
        return;
    }
    let base = params.work_offset + instance * params.work_stride;
    // Blocks of 8 rows, column-major.
    var sum = vec3<f32>(0.0);
    var column = base + params.gradients;
    var coefficient = params.c1 + row / 8u * (24u * params.proxy_len) + row % 8u;
    for (var i = 0u; i < 3u * params.proxy_len; i++) {
        sum += blob_float(coefficient) * vec3<f32>(work[column], work[column + 1u], work[column + 2u]);
        column += 3u;
        coefficient += 8u;
    }
    column = base + params.relative;
    coefficient = params.c2 + row / 8u * (32u * params.joint_len) + row % 8u;
    for (var i = 0u; i < 4u * params.joint_len; i++) {
        sum += blob_float(coefficient) * vec3<f32>(work[column], work[column + 1u], work[column + 2u]);
        column += 3u;
        coefficient += 8u;
    }
    let root = params.poses_offset + instance * params.poses_stride + 12u * params.root;
    let out = params.palettes_offset + instance * params.palettes_stride + 12u * (row / 4u) + row % 4u;
    for (var r = 0u; r < 3u; r++) {
        let at = root + 4u * r;
        var value = poses[at] * sum.x + poses[at + 1u] * sum.y + poses[at + 2u] * sum.z;
        if row % 4u == 3u {
            value += poses[at + 3u];
        }
        palettes[out + 4u * r] = value;
    }
}
