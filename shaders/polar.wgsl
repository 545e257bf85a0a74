// Stage polar: the transform of each joint to a rotation and a strain. One thread a joint.

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
    let turn = base + params.turns + 9u * joint;
    let strain = base + params.strains + 6u * joint;
    let linear = linear_part(pose + 12u * joint);
    var rotation: mat3x3<f32>;
    var stretch: vec3<f32>;
    var shear: vec3<f32>;
    if !is_hidden(linear) {
        rotation = linear;
        // A joint that did not stretch in training needs no steps.
        if blob_float(params.stretch_ranges + joint) > 0.0 {
            rotation = nearest_rotation(normed(linear));
        }
        let x = linear[0];
        let y = linear[1];
        let z = linear[2];
        // Half of a sum less 1; the product leaves a compiler no sum to split.
        stretch = 0.5 * vec3<f32>(dot3(x, x), dot3(y, y), dot3(z, z)) - 0.5;
        shear = 0.5 * vec3<f32>(dot3(x, y), dot3(x, z), dot3(y, z));
    }
    for (var i = 0u; i < 9u; i++) {
        scratch[turn + i] = rotation[i / 3u][i % 3u];
    }
    scratch[strain] = stretch.x;
    scratch[strain + 1u] = shear.x;
    scratch[strain + 2u] = shear.y;
    scratch[strain + 3u] = stretch.y;
    scratch[strain + 4u] = shear.z;
    scratch[strain + 5u] = stretch.z;
}
