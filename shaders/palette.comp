#version 450
#extension GL_GOOGLE_include_directive : require
// Stage 2: gradients and relative maps to palettes, t = c1 d + c2 q. One thread a row of t, which is
// a column of a map.

#include "params.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Poses {
    float poses[];
};
layout(set = 0, binding = 3, std430) readonly buffer Work {
    float work[];
};
layout(set = 0, binding = 4, std430) buffer Palettes {
    float palettes[];
};

void main() {
    uint item = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u
        + gl_LocalInvocationIndex;
    uint row_len = 4u * params.proxy_len;
    uint instance = item / row_len;
    uint row = item % row_len;
    if (instance >= params.instance_len) {
        return;
    }
    uint base = params.work_offset + instance * params.work_stride;
    // Blocks of 8 rows, column-major.
    precise vec3 sum = vec3(0.0);
    uint column = base + params.gradients;
    uint coefficient = params.c1 + row / 8u * (24u * params.proxy_len) + row % 8u;
    for (uint i = 0u; i < 3u * params.proxy_len; i++) {
        sum += blob_float(coefficient) * vec3(work[column], work[column + 1u], work[column + 2u]);
        column += 3u;
        coefficient += 8u;
    }
    column = base + params.relative;
    coefficient = params.c2 + row / 8u * (32u * params.joint_len) + row % 8u;
    for (uint i = 0u; i < 4u * params.joint_len; i++) {
        sum += blob_float(coefficient) * vec3(work[column], work[column + 1u], work[column + 2u]);
        column += 3u;
        coefficient += 8u;
    }
    uint root = params.poses_offset + instance * params.poses_stride + 12u * params.root;
    uint to = params.palettes_offset + instance * params.palettes_stride + 12u * (row / 4u) + row % 4u;
    for (uint r = 0u; r < 3u; r++) {
        uint at = root + 4u * r;
        precise float value = poses[at] * sum.x + poses[at + 1u] * sum.y + poses[at + 2u] * sum.z;
        if (row % 4u == 3u) {
            value += poses[at + 3u];
        }
        palettes[to + 4u * r] = value;
    }
}
