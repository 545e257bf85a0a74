#version 450
#extension GL_GOOGLE_include_directive : require
// Stage palette: gradients and relative transforms to palettes, t = c1 d + c2 q. One thread a
// transform.

#include "params.glsl"
#include "blob.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Poses {
    float poses[];
};
layout(set = 0, binding = 3, std430) readonly buffer Scratch {
    float scratch[];
};
layout(set = 0, binding = 4, std430) buffer Palettes {
    float palettes[];
};

void main() {
    uint instance = gl_WorkGroupID.y;
    uint transform = gl_GlobalInvocationID.x;
    if (transform >= params.proxy_len) {
        return;
    }
    // Rows 4 l to 4 l + 3 of t, coordinate by coordinate.
    precise vec4 x = vec4(0.0);
    precise vec4 y = vec4(0.0);
    precise vec4 z = vec4(0.0);
    uint base = params.scratch_offset + instance * params.scratch_stride;
    uint column = base + params.gradients;
    // Blocks of 8 rows, column-major: two transforms.
    uint at = params.c1 + transform / 2u * (24u * params.proxy_len) + 4u * (transform % 2u);
    for (uint i = 0u; i < 3u * params.proxy_len; i++) {
        vec4 coefficients = blob_vec4(at);
        x += coefficients * scratch[column];
        y += coefficients * scratch[column + 1u];
        z += coefficients * scratch[column + 2u];
        column += 3u;
        at += 8u;
    }
    column = base + params.relative;
    at = params.c2 + transform / 2u * (32u * params.joint_len) + 4u * (transform % 2u);
    for (uint i = 0u; i < 4u * params.joint_len; i++) {
        vec4 coefficients = blob_vec4(at);
        x += coefficients * scratch[column];
        y += coefficients * scratch[column + 1u];
        z += coefficients * scratch[column + 2u];
        column += 3u;
        at += 8u;
    }
    uint root = params.poses_offset + instance * params.poses_stride + 12u * params.root;
    uint to = params.palettes_offset + instance * params.palettes_stride + 12u * transform;
    for (uint r = 0u; r < 3u; r++) {
        uint of_root = root + 4u * r;
        precise vec4 row = poses[of_root] * x + poses[of_root + 1u] * y + poses[of_root + 2u] * z;
        row.w += poses[of_root + 3u];
        palettes[to + 4u * r] = row.x;
        palettes[to + 4u * r + 1u] = row.y;
        palettes[to + 4u * r + 2u] = row.z;
        palettes[to + 4u * r + 3u] = row.w;
    }
}
