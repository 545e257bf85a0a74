#version 450
#extension GL_GOOGLE_include_directive : require
// The pose features: how each joint has turned and moved against its parent. One thread a joint.

#include "params.glsl"
#include "blob.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Poses {
    float poses[];
};
layout(set = 0, binding = 3, std430) buffer Scratch {
    float scratch[];
};

void main() {
    uint instance = gl_WorkGroupID.y;
    uint joint = gl_GlobalInvocationID.x;
    if (joint >= params.joint_len) {
        return;
    }
    uint pose = params.poses_offset + instance * params.poses_stride;
    uint base = params.scratch_offset + instance * params.scratch_stride;
    uint to = base + params.features + 12u * joint;
    uint parent = blob_half(params.hierarchy, joint);
    if (parent == NO_JOINT) {
        for (uint i = 0u; i < 12u; i++) {
            scratch[to + i] = 0.0;
        }
        return;
    }
    vec3 origin = blob_vec3(params.origins + 3u * joint);
    uint above = pose + 12u * parent;
    uint own = pose + 12u * joint;
    for (uint r = 0u; r < 3u; r++) {
        float x = poses[above + r];
        float y = poses[above + 4u + r];
        float z = poses[above + 8u + r];
        precise vec4 row;
        for (uint c = 0u; c < 4u; c++) {
            precise float a = poses[own + c];
            precise float b = poses[own + 4u + c];
            precise float d = poses[own + 8u + c];
            if (c == 3u) {
                // The difference is taken first, so that rest is exactly 0.
                a -= poses[above + 3u];
                b -= poses[above + 7u];
                d -= poses[above + 11u];
            }
            row[c] = x * a + y * b + z * d;
        }
        row[r] -= 1.0;
        precise float moved = (row.x * origin.x + row.y * origin.y + row.z * origin.z) + row.w;
        scratch[to + 4u * r] = row.x;
        scratch[to + 4u * r + 1u] = row.y;
        scratch[to + 4u * r + 2u] = row.z;
        scratch[to + 4u * r + 3u] = moved;
    }
}
