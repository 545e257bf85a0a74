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

// Newton steps.
const uint STEPS = 7u;

// The rotation nearest to a linear part, by Newton's iteration X <- (X + X^-T) / 2.
mat3 nearest_rotation(mat3 linear) {
    precise float square = dot3(linear[0], linear[0]) + dot3(linear[1], linear[1])
        + dot3(linear[2], linear[2]);
    precise float scale = sqrt(3.0 / square);
    precise vec3 x = linear[0] * scale;
    precise vec3 y = linear[1] * scale;
    precise vec3 z = linear[2] * scale;
    for (uint i = 0u; i < STEPS; i++) {
        vec3 a = cross3(y, z);
        vec3 b = cross3(z, x);
        vec3 c = cross3(x, y);
        precise float share = 0.5 / dot3(x, a);
        x = 0.5 * x + share * a;
        y = 0.5 * y + share * b;
        z = 0.5 * z + share * c;
    }
    return mat3(x, y, z);
}

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
            rotation = nearest_rotation(linear);
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
