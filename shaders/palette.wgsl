// Stage palette: gradients and relative transforms to palettes, t = c1 d + c2 q. One thread a
// transform.

@group(0) @binding(2) var<storage, read> poses: array<f32>;
@group(0) @binding(3) var<storage, read> scratch: array<f32>;
@group(0) @binding(4) var<storage, read_write> palettes: array<f32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let instance = workgroup.y;
    let transform = 64u * workgroup.x + thread;
    if transform >= params.proxy_len {
        return;
    }
    // Rows 4 l to 4 l + 3 of t, coordinate by coordinate.
    var x = vec4<f32>(0.0);
    var y = vec4<f32>(0.0);
    var z = vec4<f32>(0.0);
    let base = params.scratch_offset + instance * params.scratch_stride;
    var column = base + params.gradients;
    // Blocks of 8 rows, column-major: two transforms.
    var at = params.c1 + transform / 2u * (24u * params.proxy_len) + 4u * (transform % 2u);
    for (var i = 0u; i < 3u * params.proxy_len; i++) {
        let coefficients = blob_vec4(at);
        x += coefficients * scratch[column];
        y += coefficients * scratch[column + 1u];
        z += coefficients * scratch[column + 2u];
        column += 3u;
        at += 8u;
    }
    column = base + params.relative;
    at = params.c2 + transform / 2u * (32u * params.joint_len) + 4u * (transform % 2u);
    for (var i = 0u; i < 4u * params.joint_len; i++) {
        let coefficients = blob_vec4(at);
        x += coefficients * scratch[column];
        y += coefficients * scratch[column + 1u];
        z += coefficients * scratch[column + 2u];
        column += 3u;
        at += 8u;
    }
    let root = params.poses_offset + instance * params.poses_stride + 12u * params.root;
    let out = params.palettes_offset + instance * params.palettes_stride + 12u * transform;
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
