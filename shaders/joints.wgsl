// Stage 1 of the kernel predictor: the joints themselves, and the base of each helper. One thread a
// map.

@group(0) @binding(2) var<storage, read> poses: array<f32>;
@group(0) @binding(3) var<storage, read_write> palettes: array<f32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let item = (group.y * groups.x + group.x) * 64u + thread;
    let instance = item / params.palette_len;
    let map = item % params.palette_len;
    if instance >= params.instance_len {
        return;
    }
    var joint = map;
    if map >= params.joint_len {
        // The group whose proxies, which follow the previous group's, include this one.
        var left = map - params.joint_len;
        var row = params.groups;
        var proxy_len = blob[row + 2u] >> 16u;
        while left >= proxy_len {
            left -= proxy_len;
            row += 6u;
            proxy_len = blob[row + 2u] >> 16u;
        }
        joint = blob[row] & 0xffffu;
    }
    let pose = params.poses_offset + instance * params.poses_stride + 12u * joint;
    let out = params.palettes_offset + instance * params.palettes_stride + 12u * map;
    for (var i = 0u; i < 12u; i++) {
        palettes[out + i] = poses[pose + i];
    }
}
