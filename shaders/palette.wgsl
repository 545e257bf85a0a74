// Stage 2: gradients and relative maps to palettes, t = c1 d + c2 q. One thread a map.

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
    let instance = item / params.proxy_len;
    let map = item % params.proxy_len;
    if instance >= params.instance_len {
        return;
    }
    // Rows 4 l to 4 l + 3 of t, coordinate by coordinate.
    var x = vec4<f32>(0.0);
    var y = vec4<f32>(0.0);
    var z = vec4<f32>(0.0);
    let base = params.work_offset + instance * params.work_stride;
    var column = base + params.gradients;
    // Blocks of 8 rows, column-major: two maps.
    var at = params.c1 + map / 2u * (24u * params.proxy_len) + 4u * (map % 2u);
    for (var i = 0u; i < 3u * params.proxy_len; i++) {
        let coefficients = blob_vec4(at);
        x += coefficients * work[column];
        y += coefficients * work[column + 1u];
        z += coefficients * work[column + 2u];
        column += 3u;
        at += 8u;
    }
    column = base + params.relative;
    at = params.c2 + map / 2u * (32u * params.joint_len) + 4u * (map % 2u);
    for (var i = 0u; i < 4u * params.joint_len; i++) {
        let coefficients = blob_vec4(at);
        x += coefficients * work[column];
        y += coefficients * work[column + 1u];
        z += coefficients * work[column + 2u];
        column += 3u;
        at += 8u;
    }
    let root = params.poses_offset + instance * params.poses_stride + 12u * params.root;
    let out = params.palettes_offset + instance * params.palettes_stride + 12u * map;
    for (var r = 0u; r < 3u; r++) {
        let of_root = root + 4u * r;
        var row = poses[of_root] * x + poses[of_root + 1u] * y + poses[of_root + 2u] * z;
        row.w += poses[of_root + 3u];
        palettes[out + 4u * r] = row.x;
        palettes[out + 4u * r + 1u] = row.y;
        palettes[out + 4u * r + 2u] = row.z;
        palettes[out + 4u * r + 3u] = row.w;
    }
}
