// Stage joints: copies the joints' transforms, and gives each helper the transform of its dominant
// joint. One thread a transform.

@group(0) @binding(2) var<storage, read> poses: array<f32>;
@group(0) @binding(3) var<storage, read_write> palettes: array<f32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let instance = workgroup.y;
    let transform = 64u * workgroup.x + thread;
    if transform >= params.palette_len {
        return;
    }
    var joint = transform;
    if transform >= params.joint_len {
        // Finds the group of this helper; the helpers of a group follow those of the group before
        // it.
        var left = transform - params.joint_len;
        var row = params.groups;
        var proxy_len = blob[row + 2u] >> 16u;
        while left >= proxy_len {
            left -= proxy_len;
            row += 8u;
            proxy_len = blob[row + 2u] >> 16u;
        }
        joint = blob[row] & 0xffffu;
    }
    let pose = params.poses_offset + instance * params.poses_stride + 12u * joint;
    let out = params.palettes_offset + instance * params.palettes_stride + 12u * transform;
    for (var i = 0u; i < 12u; i++) {
        if joint == NO_JOINT {
            // Helpers of an envelope without joints start from the identity.
            palettes[out + i] = f32(i % 5u == 0u);
        } else {
            palettes[out + i] = poses[pose + i];
        }
    }
}
