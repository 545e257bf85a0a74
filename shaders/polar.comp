#version 450
#extension GL_GOOGLE_include_directive : require
// Stage polar: the transform of each joint to a rotation and a strain. One thread a joint.

#include "params.glsl"
#include "blob.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Poses {
    float poses[];
};
layout(set = 0, binding = 3, std430) buffer Scratch {
    float scratch[];
};

#include "joint.glsl"
#include "nearest.glsl"

void main() {
    uint instance = gl_WorkGroupID.y;
    uint joint = gl_GlobalInvocationID.x;
    if (joint >= params.joint_len) {
        return;
    }
    uint pose = params.poses_offset + instance * params.poses_stride;
    uint base = params.scratch_offset + instance * params.scratch_stride;
    uint turn = base + params.turns + 9u * joint;
    uint strain = base + params.strains + 6u * joint;
    mat3 linear = linear_part(pose + 12u * joint);
    mat3 rotation = mat3(0.0);
    precise vec3 stretch = vec3(0.0);
    precise vec3 shear = vec3(0.0);
    if (!is_hidden(linear)) {
        rotation = linear;
        // A joint that did not stretch in training needs no steps.
        if (blob_float(params.stretch_ranges + joint) > 0.0) {
            rotation = nearest_rotation(normed(linear));
        }
        vec3 x = linear[0];
        vec3 y = linear[1];
        vec3 z = linear[2];
        stretch = 0.5 * (vec3(dot3(x, x), dot3(y, y), dot3(z, z)) - 1.0);
        shear = 0.5 * vec3(dot3(x, y), dot3(x, z), dot3(y, z));
    }
    for (uint i = 0u; i < 9u; i++) {
        scratch[turn + i] = rotation[i / 3u][i % 3u];
    }
    scratch[strain] = stretch.x;
    scratch[strain + 1u] = shear.x;
    scratch[strain + 2u] = shear.y;
    scratch[strain + 3u] = stretch.y;
    scratch[strain + 4u] = shear.z;
    scratch[strain + 5u] = stretch.z;
}
